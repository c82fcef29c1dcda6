// Six joints without a special structure, compiled once for every instruction set.
#include "families/general/elimination.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

extern const EliminationSolvers elimination_solvers = {solve_singly<General6>, prove};

}  // namespace urdf_ik::URDF_IK_LEVEL
