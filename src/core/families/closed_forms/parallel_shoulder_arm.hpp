// An arm whose axes 1, 2 and 3 are parallel.
#pragma once

#include "families/imperfect/imperfect_arm.hpp"

namespace urdf_ik {

// The relation of a pair of the last three axes; it decides the method for joints 4 and 6.
enum class LastAxes { intersecting_56, parallel_56, intersecting_45, parallel_45, general };

struct ParallelShoulderArm {
    IdealFrames ideal;
    Written<6> written;
};

using ParallelShoulderSolvers = FamilySolvers<ParallelShoulderArm, 5>;  // by LastAxes

}  // namespace urdf_ik
