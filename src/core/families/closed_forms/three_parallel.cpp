// Arms with three parallel axes after the first, compiled once for every instruction set.
#include "families/closed_forms/three_parallel.hpp"
#include "families/imperfect/imperfect.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

extern const ThreeParallelSolvers three_parallel_solvers =
    solvers_of<ThreeParallel<Hand::intersecting_56>, ThreeParallel<Hand::general>>;

}  // namespace urdf_ik::URDF_IK_LEVEL
