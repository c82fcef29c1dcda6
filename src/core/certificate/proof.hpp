// The proof of one pose's answer as data, for an independent check.
#pragma once

#include "certificate/status.hpp"

namespace urdf_ik {

// Exactly `many` roots, counted by multiplicity, with |d| <= across in the first 6 - lost of the orthonormal directions and
// |d| <= along in the others, d from the centre.
struct ProvenCluster {
    static constexpr int most = 8;
    double centre[6][2], directions[6][6][2];  // real and imaginary parts; directions by rows
    double across, along;
    int lost, many;
};

struct Proof {
    static constexpr int most = 16;
    Status status;
    Expected expected;
    int roots, clusters;
    double root[most][6][2];           // joint values, real and imaginary part; of a conjugate pair both
    double inner[most], outer[most];   // one root within inner of each joint value, no other one within outer
    bool real[most];
    ProvenCluster cluster[ProvenCluster::most];
};

}  // namespace urdf_ik
