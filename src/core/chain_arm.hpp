// A chain of any number of joints, for forward kinematics. Its numbers are defined as in Written, see arm.hpp.
#pragma once

#include "kinematics/arm.hpp"

namespace urdf_ik {

struct ChainArm {
    int joints;
    const Motion* step;  // joints + 1
    const bool* slides;  // joints
};

// For joint vectors Q (m, joints) with angles of any size: poses (m, 4, 4) of the tip; Jacobians (m, 6, joints) at the tip, linear
// rows above angular ones; axes (m, 6, joints), origin above direction.
struct ChainFunctions {
    void (*poses)(const ChainArm&, const double* Q, long m, double* T);
    void (*jacobians)(const ChainArm&, const double* Q, long m, double* J);
    void (*axes)(const ChainArm&, const double* Q, long m, double* J);
};

}  // namespace urdf_ik
