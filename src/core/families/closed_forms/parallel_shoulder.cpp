// Arms whose first three axes are parallel, compiled once for every instruction set.
#include "families/closed_forms/parallel_shoulder.hpp"
#include "families/imperfect/imperfect.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

extern const ParallelShoulderSolvers parallel_shoulder_solvers =
    solvers_of<ParallelShoulder<LastAxes::intersecting_56>, ParallelShoulder<LastAxes::parallel_56>,
               ParallelShoulder<LastAxes::intersecting_45>, ParallelShoulder<LastAxes::parallel_45>,
               ParallelShoulder<LastAxes::general>>;

}  // namespace urdf_ik::URDF_IK_LEVEL
