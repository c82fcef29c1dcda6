// Arms whose axes 2, 3 and 4 meet, compiled once for every instruction set.
#include "families/closed_forms/spherical_middle.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

extern const SphericalMiddleSolvers spherical_middle_solvers;
const SphericalMiddleSolvers spherical_middle_solvers = {{
    solve_closed_form<SphericalMiddle<LastPair::intersecting>>,
    solve_closed_form<SphericalMiddle<LastPair::parallel>>,
    solve_singly<SphericalMiddle<LastPair::general>>,
}};

}  // namespace urdf_ik::URDF_IK_LEVEL
