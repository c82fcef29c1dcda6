// The general elimination for use by other families; see elimination.hpp.
#pragma once

#include "answers/answer.hpp"
#include "families/general/elimination_arm.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Adds to the columns (16) the solutions of one pose that they lack. `complete` and `clustered` are proven: either all sixteen
// complex solutions are certified, or as many real ones as the determinant can have zeros on the circle.
Status complete(const EliminationArm& arm, const Goal<double>& goal, const Columns<6>& columns);
// Whether the solutions in the columns, which another way found, are proven to be all: as many are certified as the determinant can
// have zeros. Looks for no other.
bool are_all(const EliminationArm& arm, const Goal<double>& goal, const Columns<6>& columns);

}  // namespace urdf_ik::URDF_IK_LEVEL
