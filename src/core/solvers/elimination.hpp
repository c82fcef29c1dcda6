// Arms of six joints solved by elimination, from named values.
#pragma once

#include "families/general/elimination_arm.hpp"
#include "solvers/common.hpp"

namespace urdf_ik {

void read(const Values& values, EliminationArm& to);
// The same without the variant.
void read_common(const Values& values, EliminationArm& to);
// The `index`-th of several variants. The first dimension of each array is the variant.
void read_variant(const Values& values, int variants, int index, EliminationVariant& to);

}  // namespace urdf_ik
