// The general elimination for use by other families; see elimination.hpp.
#pragma once

#include "answers/answer.hpp"
#include "families/general/elimination_arm.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Adds to the columns (16) the solutions of one pose that they lack. `complete` is proven for six turning joints whose known
// poses have all sixteen solutions; for arms near a special one it is a count that leaves out solutions far from real.
Status complete(const EliminationArm& arm, const Goal<double>& goal, const Columns<6>& columns);

}  // namespace urdf_ik::URDF_IK_LEVEL
