// Arms near one with a spherical wrist or three parallel axes, compiled once for every instruction set.
#include "families/imperfect/imperfect.hpp"
#include "families/closed_forms/spherical_wrist.hpp"
#include "families/closed_forms/three_parallel.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

template <Shoulder kind> inline constexpr auto near_wrist = solve_singly<Imperfect<SphericalWrist<kind>>>;
template <Hand kind> inline constexpr auto near_parallel = solve_singly<Imperfect<ThreeParallel<kind>>>;

extern const ImperfectSolvers imperfect_solvers;
const ImperfectSolvers imperfect_solvers = {
    {near_wrist<Shoulder::parallel_23>, near_wrist<Shoulder::intersecting_12>, near_wrist<Shoulder::parallel_12>,
     near_wrist<Shoulder::general>},
    {near_parallel<Hand::intersecting_56>, near_parallel<Hand::general>},
};

}  // namespace urdf_ik::URDF_IK_LEVEL
