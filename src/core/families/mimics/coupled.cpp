// Arms in which joints mimic others, compiled once for every instruction set.
#include "families/mimics/coupled.hpp"
#include "families/mimics/hollow_wrist.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

extern const CoupledSolvers coupled_solvers = {solve_coupled<1>, solve_coupled<2>, solve_coupled<3>, solve_coupled<4>,
                                               solve_singly<HollowWrist>};

}  // namespace urdf_ik::URDF_IK_LEVEL
