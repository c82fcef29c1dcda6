// The general elimination as other families ask for it; see elimination.hpp.
#pragma once

#include "../answer.hpp"
#include "elimination_arm.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Adds to the columns the solutions of one pose that they lack. from_scratch: what they hold, if anything, is no closed
// form's answer, whose folds are simple.
void complete(const EliminationArm& arm, const Goal<double>& goal, const Columns<6>& columns, bool from_scratch);

}  // namespace urdf_ik::URDF_IK_LEVEL
