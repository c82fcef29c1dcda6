// The proof of one pose's answer as data, for an independent check.
#pragma once

#include "certify/status.hpp"

namespace urdf_ik {

struct Proof {
    static constexpr int most = 16;
    Status status;
    Expected expected;
    int roots;
    double root[most][6][2];           // joint values, real and imaginary part; of a conjugate pair both
    double inner[most], outer[most];   // one root within inner of each joint value, no other one within outer
    bool real[most];
};

}  // namespace urdf_ik
