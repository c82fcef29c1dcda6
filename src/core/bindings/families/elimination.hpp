// Six joints without a structure to use, from named values.
#pragma once

#include "bindings/solver.hpp"

namespace urdf_ik {

void read(const Values& values, EliminationArm& to);
void add_elimination(nb::module_& m);

}  // namespace urdf_ik
