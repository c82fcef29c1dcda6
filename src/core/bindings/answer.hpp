// Answers as objects of the Python class `kind`, which is derived from Answer. That for a single pose owns the numbers and makes
// each array at its first use: making three NumPy arrays takes longer than most solvers, and few callers use all of them.
#pragma once

#include "bindings/module.hpp"
#include "bindings/python_values.hpp"
#include "solvers/solver.hpp"

namespace urdf_ik {

// A solver and the dataclass from which it was made. Pickling stores the dataclass.
struct PySolver {
    nb::object arm;
    SolverPointer solver;

    explicit PySolver(nb::object arm_) : arm(std::move(arm_)), solver(make_solver(PythonValues(arm, "arm"))) {}
};

// The answer for a pose given as a NumPy array. None unless T is a C-ordered float64 array (4, 4) that is a pose.
nb::object solve_one(const PySolver& of, nb::handle kind, nb::handle arm, nb::handle branches, nb::handle T, nb::handle q_ref);

// The answer for a batch of targets (..., 4, 4), or (..., numbers) for a task; it keeps T. `values`: of the redundancy parameters.
// `out`: an answer for a batch of the same shape, which is overwritten and returned. None unless the arrays are C-ordered, of
// float64 and of fitting shapes, and every target is valid.
nb::object solve_many(const PySolver& of, nb::handle kind, nb::handle arm, nb::handle branches, nb::handle T, nb::handle q_ref,
                      nb::handle values, int threads, nb::handle out);

}  // namespace urdf_ik
