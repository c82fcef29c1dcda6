// Arms near one whose first three axes are parallel, or whose axes 2 to 4 meet, compiled once for every instruction set.
#include "families/closed_forms/parallel_shoulder.hpp"
#include "families/closed_forms/spherical_middle.hpp"
#include "families/imperfect/imperfect.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

template <LastAxes kind> inline constexpr auto near_shoulder = solve_singly<Imperfect<ParallelShoulder<kind>>>;
template <LastPair kind> inline constexpr auto near_middle = solve_singly<Imperfect<SphericalMiddle<kind>>>;

extern const ImperfectSolversToo imperfect_solvers_too;
const ImperfectSolversToo imperfect_solvers_too = {
    {near_shoulder<LastAxes::intersecting_56>, near_shoulder<LastAxes::parallel_56>, near_shoulder<LastAxes::intersecting_45>,
     near_shoulder<LastAxes::parallel_45>, near_shoulder<LastAxes::general>},
    {near_middle<LastPair::intersecting>, near_middle<LastPair::parallel>, near_middle<LastPair::general>},
};

}  // namespace urdf_ik::URDF_IK_LEVEL
