// The general elimination for use by other families; see elimination.hpp.
#pragma once

#include "families/general/elimination_arm.hpp"
#include "propose/answer.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Adds to the columns (16) the solutions of one pose that they lack. The status is incomplete, or complete where that is proven:
// all sixteen complex solutions are certified, or as many real ones as the determinant can have zeros on the circle.
Status complete(const EliminationArm& arm, const Goal<double>& goal, const Columns<6>& columns);
// Whether the solutions in the columns, which another way found, are proven to be all: as many are certified as the determinant can
// have zeros. The columns are then the certified ones. Looks for no other.
bool prove_by_count(const EliminationArm& arm, const Goal<double>& goal, const Columns<6>& columns);

}  // namespace urdf_ik::URDF_IK_LEVEL
