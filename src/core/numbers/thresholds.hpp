// Thresholds at which the solvers change their method. The tolerances for verifying solutions are in arm.hpp.
// All are dimensionless: lengths are shares of the arm's size, angles are in rad.
#pragma once

namespace urdf_ik {

// Newton's method stops when its error falls to FINISHED, the rounding of the forward kinematics of six joints. Below CONVERGED
// it counts as converged, even if another step might still gain a digit.
inline constexpr double FINISHED = 1.8e-15, CONVERGED = 2e-14;
// An iteration stops when its error has not fallen by a third in this many rounds. PATIENCE is for starts that may lead to no
// solution, LONG_PATIENCE for starts that should lead to one, perhaps along a narrow valley.
inline constexpr int PATIENCE = 7, LONG_PATIENCE = 60;
// Joint vectors that almost reach a target may lie along a curved valley: a step along it causes an error across it. If a step
// does not reduce an error below HALF_OF_THE_DIGITS, the next step is damped by HELD, which suppresses motion along the valley.
inline constexpr double HELD = 1e-6;
// Rounding error of a closed form: of its squared margins, which are of order one, 32 units in the last place; of its targets [rad,
// share of size], 26: twelve operations on each number in to_frame_1(), and seven rotations whose cosines and sines are rounded,
// two each.
inline constexpr double ROUNDING = 7e-15;
// What rounding leaves of a number behind a double root, of which half of the digits are lost: seven times the root of ROUNDED,
// 1.5e-8, is more than the coefficients of the core's quartics and determinants amplify. Margins behind a quartic, the sine of an
// angle that follows from its cosine, and the noise of a determinant's harmonics are compared with it.
inline constexpr double HALF_OF_THE_DIGITS = 1e-7;
// A coefficient or length [share of size] below this, or a squared sine or lever arm, is zero to rounding: a number of order one
// that has passed through a hundred operations is known to 1e-14, and may have lost two more digits. As the smallest damping of a
// step it changes nothing at a regular solution, and avoids a division by zero at an exactly singular one. A curve of solutions
// keeps the pose to it.
inline constexpr double VANISHING = 1e-12;
// Two joint values [rad, share of size] that differ by less are one value: solutions are verified to 1e-10, and a regular one's
// joints are then known to 1e-10 over the smallest singular value, which is above 1e-4 but beside singularities.
inline constexpr double SAME = 1e-6;
// Sums of rounded products and roots of positive numbers are too small by less than this factor: up to 4000 operations.
inline constexpr double SLACK_OF_SUMS = 1.0 + 1e-12;
// What is nearer than this is looked at more closely: a squared sine or lever arm, a coefficient, or a smallest singular value, to
// zero; an extremum to zero; a complex root (in its logarithm) to the unit circle; two solutions, which may be one double root, to
// each other in every joint. At 1e-3 rad the digits that are lost, three or six, leave nine. In most places it decides the cost
// only. It decides what is proven and kept in slide_position.hpp and slides.hpp (rests below -NEAR are no solutions), and which two
// solutions may be one: is_new, inclusion.cpp and srs_boxes.hpp.
inline constexpr double NEAR = 1e-3;
// If the Jacobian's smallest singular value is below this, a second solution may be close by.
inline constexpr double NEAR_FOLD = 5e-3;

}  // namespace urdf_ik
