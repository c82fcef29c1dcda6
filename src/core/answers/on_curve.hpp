// Whether a singular solution lies on a curve of solutions.
#pragma once

#include "answers/answer.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Whether a singular solution lies on a curve of solutions, and whether one in the columns does.
bool is_on_curve(const Written<6>& arm, const Goal<double>& goal, const double (&q)[6]);
bool keep_curve(const Written<6>& arm, const Goal<double>& goal, const Columns<6>& columns);

}  // namespace urdf_ik::URDF_IK_LEVEL
