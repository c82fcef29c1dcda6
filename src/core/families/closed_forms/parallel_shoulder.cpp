// Arms whose first three axes are parallel, compiled once for every instruction set.
#include "families/closed_forms/parallel_shoulder.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

template <LastAxes kind> using Of = ParallelShoulder<kind>;

extern const ParallelShoulderSolvers parallel_shoulder_solvers;
const ParallelShoulderSolvers parallel_shoulder_solvers = {{
    solve_closed_form<Of<LastAxes::intersecting_56>>,
    solve_closed_form<Of<LastAxes::parallel_56>>,
    solve_closed_form<Of<LastAxes::intersecting_45>>,
    solve_closed_form<Of<LastAxes::parallel_45>>,
    solve_singly<Of<LastAxes::general>>,
}};

}  // namespace urdf_ik::URDF_IK_LEVEL
