// An arm whose axes 2, 3 and 4 are parallel.
#pragma once

#include "families/imperfect/imperfect_arm.hpp"

namespace urdf_ik {

// Whether axes 5 and 6 intersect, which decides joints 1 and 5 one after the other, or are skew: a quartic.
enum class Hand { intersecting_56, general };

struct ThreeParallelArm {
    IdealFrames ideal;
    Written<6> written;
    double along;                 // height of axis 6 along the parallel axes, while it lies across them [m]
    double turn_3, turn_4;        // 1 or -1: whether axes 3 and 4 point as axis 2 does, or against it
    double cos_first, sin_first;  // of the angle from the parallel axes to axis 5
    bool square_wrist;            // axis 5 is at right angles to axes 4 and 6: the two wrists differ by half turns
};

using ThreeParallelSolvers = FamilySolvers<ThreeParallelArm, 2>;  // by Hand

}  // namespace urdf_ik
