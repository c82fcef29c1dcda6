// Arms whose axes 2, 3 and 4 meet, compiled once for every instruction set.
#include "families/closed_forms/spherical_middle.hpp"
#include "families/imperfect/imperfect.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

extern const SphericalMiddleSolvers spherical_middle_solvers =
    solvers_of<SphericalMiddle<LastPair::intersecting>, SphericalMiddle<LastPair::parallel>, SphericalMiddle<LastPair::general>>;

}  // namespace urdf_ik::URDF_IK_LEVEL
