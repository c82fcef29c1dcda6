// Where the solvers change their method. What decides whether a solution is right is in arm.hpp's Tolerances instead.
// All are dimensionless: lengths count as shares of the arm's size, angles in rad.
#pragma once

#include "arithmetic/level.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Newton's method rests when the error falls to what forward kinematics of six joints rounds to; below CONVERGED it has
// converged, whether or not another step would still gain a digit.
inline constexpr double FINISHED = 1.8e-15, CONVERGED = 2e-14;
// An iteration that has not gained a third in this many rounds has come to rest: from a start that may belong to no
// solution, and from one that should belong to one (which may lie along a narrow valley).
inline constexpr int PATIENCE = 7, LONG_PATIENCE = 60;
// Least damping of a step: below it the damping changes nothing at a regular solution, without it the step at an
// exactly singular one is a division by zero.
inline constexpr double LEAST_DAMPING = 1e-12;
// A valley of joint vectors that all but reach a target bends: a step along it leaves an error across it. Where a step has made
// an error below NEARLY no smaller, the next one is damped by HELD, which holds the direction along the valley.
inline constexpr double NEARLY = 1e-7, HELD = 1e-6;
// The squared margins of a closed form (of order one) carry this much rounding: 32 units in the last place.
inline constexpr double ROUNDING = 7e-15;
// The same after a step that takes the root of a quartic.
inline constexpr double ROUGH = 1e-7;
// What is left after a step whose own margin is m carries this much over m.
inline constexpr double ROUGH_BY_MARGIN = 1e-13;
// Squared sine or arm below which a joint is so nearly free that rounding moves its angle about.
inline constexpr double ALMOST_ALIGNED = 1e-12;
// Two roots of a quartic whose squared distance on the unit circle is below this may lead to one solution.
inline constexpr double ROOTS_CROWDED = 1e-4;
// After the root of a quartic, what is left to the elbow carries this much over the squared arm of the wrist.
inline constexpr double ROUGH_BY_ROOT = 1e-9;
// Squared sines and squared arms below which a pose counts as near a singularity, so that its solutions are asked
// whether the Jacobian has lost rank.
inline constexpr double NEAR = 1e-3;
// Product of a solution's margins and squared arms, the square of the Jacobian's determinant up to a factor, below which it
// is asked the same although none of them is small.
inline constexpr double SMALL_TOGETHER = 1e-11;
// Two solutions nearer than this to each other in every joint are asked whether they are one double root.
inline constexpr double BESIDE = 1e-3;
// Below this smallest singular value of the Jacobian a second solution may be next door.
inline constexpr double NEAR_FOLD = 5e-3;
// The least value from which a joint that is all but free is tried, in steps of half a turn over it.
inline constexpr int AROUND = 12;

}  // namespace urdf_ik::URDF_IK_LEVEL
