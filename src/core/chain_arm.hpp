// A chain of any number of joints, for forward kinematics. Its numbers are defined as in Written, see arm.hpp.
#pragma once

#include "arm/arm.hpp"

namespace urdf_ik {

struct ChainArm {
    int joints;
    const Motion* step;  // joints + 1
    const bool* slides;  // joints
};

// What the swivel angle of seven joints is measured from: the wrist in the tip's frame [m]; shoulder [m] and direction of axis 1 in
// the base.
struct SwivelEnds {
    double wrist[3], shoulder[3], up[3];
};

// For the inverses of Jacobians: lengths are counted as shares of size [m]; where the smallest singular value falls below
// `singular`, there is none. Seven joints hold a parameter: joint `held`, or the swivel angle where that is negative.
struct InverseScale {
    double size, singular;
    int held;
    SwivelEnds swivel;
};

// For joint vectors Q (m, joints) with angles of any size: poses (m, 4, 4) of the tip; Jacobians (m, 6, joints) at the tip, linear
// rows above angular ones; axes (m, 6, joints), origin above direction.
struct ChainFunctions {
    void (*poses)(const ChainArm&, const double* Q, long m, double* T);
    void (*jacobians)(const ChainArm&, const double* Q, long m, double* J);
    void (*axes)(const ChainArm&, const double* Q, long m, double* J);
};

// Least-squares inverses X of the Jacobians of at most six joints (m, joints, 6); of seven joints above the derivative of the
// parameter that they hold (m, 7, 7). NaN where there is none, or where Q is NaN.
struct InverseFunctions {
    void (*inverses)(const ChainArm&, const double* Q, const InverseScale&, long m, double* X);
};

}  // namespace urdf_ik
