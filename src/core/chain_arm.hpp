// A chain of any number of joints, for forward kinematics. Its numbers are defined as in Written, see arm.hpp.
#pragma once

#include "kinematics/arm.hpp"

namespace urdf_ik {

struct ChainArm {
    int joints;
    const Motion* step;  // joints + 1
    const bool* slides;  // joints
};

// For the inverses of Jacobians: lengths are counted as shares of size [m]; where the smallest singular value falls below
// `singular`, there is none.
struct InverseScale {
    double size, singular;
};

// For joint vectors Q (m, joints) with angles of any size: poses (m, 4, 4) of the tip; Jacobians (m, 6, joints) at the tip, linear
// rows above angular ones; axes (m, 6, joints), origin above direction.
// Least-squares inverses X of the Jacobians of at most six joints (m, joints, 6); of seven joints below a further row (7) or (m,
// 7), `apart` numbers from one to the next (m, 7, 7). NaN where there is none, or where Q is NaN.
struct ChainFunctions {
    void (*poses)(const ChainArm&, const double* Q, long m, double* T);
    void (*jacobians)(const ChainArm&, const double* Q, long m, double* J);
    void (*axes)(const ChainArm&, const double* Q, long m, double* J);
    void (*inverses)(const ChainArm&, const double* Q, const double* row, long apart, const InverseScale&, long m, double* X);
};

}  // namespace urdf_ik
