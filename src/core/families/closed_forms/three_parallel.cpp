// Arms with three parallel axes after the first, compiled once for every instruction set.
#include "families/closed_forms/three_parallel.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

using WithIntersecting56 = ThreeParallel<Hand::intersecting_56>;
using General = ThreeParallel<Hand::general>;

extern const ThreeParallelSolvers three_parallel_solvers;
const ThreeParallelSolvers three_parallel_solvers = {{solve_closed_form<WithIntersecting56>, solve_singly<General>}};

}  // namespace urdf_ik::URDF_IK_LEVEL
