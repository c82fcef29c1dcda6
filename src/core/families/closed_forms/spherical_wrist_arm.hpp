// An arm with a spherical wrist.
#pragma once

#include "families/imperfect/imperfect_arm.hpp"

namespace urdf_ik {

// The relation of the first three axes; it decides the method for joints 1 to 3.
enum class Shoulder { parallel_23, intersecting_12, parallel_12, general };

struct SphericalWristArm {
    IdealFrames ideal;
    Written<6> written;
    // The wrist centre in frame 3; its distance from axis 3 and its direction there; its height along axis 2's frame.
    double centre[3], rho, cos_phi, sin_phi, height;
    // parallel_23: joint 3's value is the bend of the elbow minus this [rad].
    double bend_offset;
    // intersecting_12: cos(t3 + shift) = swing[0] |p|^2 + swing[1]; parallel_12: sin(t3 + phi) = swing[0] cos(alpha1) p_z
    // + swing[1].
    double swing[2];
    bool square_wrist;  // alpha 4 and alpha 5 are exactly +-90 degrees, so the two wrists differ by half turns
};

using SphericalWristSolvers = FamilySolvers<SphericalWristArm, 4>;  // by Shoulder

}  // namespace urdf_ik
