// A chain of any number of joints, for forward kinematics; its numbers are those of Written in arm.hpp.
#pragma once

#include "kinematics/arm.hpp"

namespace urdf_ik {

struct ChainArm {
    int joints;
    const Motion* step;  // joints + 1
    const bool* slides;  // joints
};

// For joint vectors Q (m, joints) of any size: poses (m, 4, 4) of the tip; or of each joint its column of the Jacobian
// at the tip, linear rows above angular ones, (m, 6, joints); or in its place the axis: origin above direction.
struct ChainFunctions {
    void (*poses)(const ChainArm&, const double* Q, long m, double* T);
    void (*jacobians)(const ChainArm&, const double* Q, long m, double* J);
    void (*axes)(const ChainArm&, const double* Q, long m, double* J);
};

}  // namespace urdf_ik
