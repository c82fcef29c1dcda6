// An arm whose axes 2, 3 and 4 meet.
#pragma once

#include "families/imperfect/imperfect_arm.hpp"

namespace urdf_ik {

// The relation of axes 5 and 6; it decides the method for joint 1.
enum class LastPair { intersecting, parallel, general };

struct SphericalMiddleArm {
    IdealFrames ideal;
    Written<6> written;
    // Where axes 2 to 4 meet: in frame 1 before joint 1 turns, and in frame 5 before joint 5 turns [m].
    double centre[3], centre_5[3];
};

using SphericalMiddleSolvers = FamilySolvers<SphericalMiddleArm, 3>;  // by LastPair

}  // namespace urdf_ik
