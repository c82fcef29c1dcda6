// S-R-S arms, compiled once for every instruction set.
#include "srs_near.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

extern const SrsSolvers srs_solvers;
const SrsSolvers srs_solvers = {solve_closed_form<Srs>, solve_singly<SrsNear>};

}  // namespace urdf_ik::URDF_IK_LEVEL
