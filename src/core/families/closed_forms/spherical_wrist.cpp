// Arms with a spherical wrist, compiled once for every instruction set.
#include "families/closed_forms/spherical_wrist.hpp"
#include "families/imperfect/imperfect.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

extern const SphericalWristSolvers spherical_wrist_solvers =
    solvers_of<SphericalWrist<Shoulder::parallel_23>, SphericalWrist<Shoulder::intersecting_12>,
               SphericalWrist<Shoulder::parallel_12>, SphericalWrist<Shoulder::general>>;

}  // namespace urdf_ik::URDF_IK_LEVEL
