// The referee: all solutions of six turning joints at one pose where doubles leave it open, by the elimination with enough digits.
//
// The determinant of the arm whose axes are moved by NUDGE has sixteen simple zeros (determinant.hpp). Each real solution of the
// arm as written has a zero: within about NUDGE / s for a regular one with the smallest singular value s, and for one of
// multiplicity m m zeros within about the m-th root of NUDGE, which may leave the circle in pairs. So every zero on the circle, and
// every pair within NEAR_REAL, is followed by Newton's method on the arm as written:
//   complete    each zero on the circle has a certified solution, no two have the same, and pairs lead to none
//   clustered   each has a solution that keeps the pose to rounding; some share one
//   continuum   a curve of solutions keeps the pose
//   incomplete  a group of discs is not resolved, or a regular solution is known at which there is no zero
// Unless some share one, the zeros far from real are certified, too. What Newton's method finds from one without a certificate
// becomes a solution.
#pragma once

#include "propose/answer.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Adds to the columns the solutions that they lack, and returns the status: incomplete if a joint slides.
Status refer(const Written<6>& arm, const Goal<double>& goal, const Columns<6>& columns);

}  // namespace urdf_ik::URDF_IK_LEVEL
