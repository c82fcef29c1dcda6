// Whether a singular solution lies on a curve of solutions.
#pragma once

#include "propose/answer.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A rank counts as lost at a solution where the singular value is below this.
inline constexpr double LOST_RANK = 1e-4;

// Whether a singular solution lies on a curve of solutions, and whether one in the columns does.
bool is_on_curve(const Written<6>& arm, const Goal<double>& goal, const double (&q)[6]);
bool any_is_on_curve(const Written<6>& arm, const Goal<double>& goal, const Columns<6>& columns);

}  // namespace urdf_ik::URDF_IK_LEVEL
