// Arms with a spherical wrist, compiled once for every instruction set.
#include "families/closed_forms/spherical_wrist.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

extern const SphericalWristSolvers spherical_wrist_solvers;
const SphericalWristSolvers spherical_wrist_solvers = {{
    solve_closed_form<SphericalWrist<Shoulder::parallel_23>>,
    solve_closed_form<SphericalWrist<Shoulder::intersecting_12>>,
    solve_closed_form<SphericalWrist<Shoulder::parallel_12>>,
    solve_singly<SphericalWrist<Shoulder::general>>,
}};

}  // namespace urdf_ik::URDF_IK_LEVEL
