// Solves a batch on several threads, part by part.
#pragma once

#include "bindings/signals.hpp"
#include "solvers/solver.hpp"

namespace urdf_ik {

// Solve a batch. Returns the index of the first invalid target, or -1. Called without the GIL. If `stop` ends the work early, the
// answers are incomplete. After the return no thread works on the batch.
long solve_shared(const Solver& solver, const Batch& batch, int threads, const Stop& stop);

}  // namespace urdf_ik
