// What a single pose's solve returns: an object that owns the numbers and makes its arrays when they are asked for.
// Making three NumPy arrays takes longer than most solvers; few callers ask for all of them.
#pragma once

#include "arms/solver.hpp"
#include "bindings/module.hpp"

namespace urdf_ik {

// The answer, of the Python class `kind` that is derived from Answer, for a pose given as a NumPy array; None where that
// is anything but a (4, 4) float64 array in C order, or no pose.
nb::object solve_one(const Solver& solver, nb::handle kind, nb::handle arm, nb::handle branches, nb::handle T, nb::handle q_ref);

}  // namespace urdf_ik
