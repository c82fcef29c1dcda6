// The answer for a single pose: an object that owns the numbers and makes each array at its first use. Making three NumPy arrays
// takes longer than most solvers, and few callers use all of them.
#pragma once

#include "arms/solver.hpp"
#include "bindings/module.hpp"

namespace urdf_ik {

// The answer for a pose given as a NumPy array, as an object of the Python class `kind`, which is derived from Answer. None unless
// T is a C-ordered float64 array (4, 4) that is a pose.
nb::object solve_one(const Solver& solver, nb::handle kind, nb::handle arm, nb::handle branches, nb::handle T, nb::handle q_ref);

}  // namespace urdf_ik
