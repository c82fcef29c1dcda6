// Solves a batch on several threads, part by part.
#pragma once

#include "arms/solver.hpp"
#include "bindings/signals.hpp"

namespace urdf_ik {

// Solve a batch; index of the first target that is no pose, -1 where all are. Called without the GIL. Where `stop` says
// so it ends early, and the answers are incomplete. In any case no thread works on the batch afterwards.
long solve_shared(const Solver& solver, const Batch& batch, int threads, const Stop& stop);

}  // namespace urdf_ik
