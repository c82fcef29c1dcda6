// An S-R-S arm.
#pragma once

#include "arm/arm.hpp"

namespace urdf_ik {

// Three axes that meet: R(h1, q1) R(h2, q2) R(h3, q3) = F1 Rz(q1) Rx(alpha) Rz(q2 + shift) Rx(beta) Rz(q3) F3^T.
struct MeetingAxes {
    double cos_alpha, sin_alpha, cos_beta, sin_beta, shift;
    bool square;  // so the two solutions differ by half turns
};

struct SrsArm {
    Ends ideal;  // the origin of frame 1 is S, the solved point is W
    Written<7> written;
    MeetingAxes shoulder, wrist;
    // The elbow's frame turns with the upper arm: z along axis 4, x from the parallel to axis 4 through S to axis 4.
    double to_frame_3[3][3], from_frame_5[3][3];
    // Distance from S to the parallel axis 4, from there to W, height of W along axis 4 [m]; joint 4's angle where the
    // two are in line.
    double upper, fore, along, zero_4;
    double clamp;         // how far below zero a margin may fall before its branch is given up
    double imperfection;  // how far its poses are from those of the arm as written [rad, share of size]; 0: exact
    double off[7][3];     // from each axis of the arm as written to this arm's, in the joint's frame at zero [m]
    double together;      // see Clear in propose/branch.hpp
    double value;         // the default swivel angle
};

struct SrsSolvers {
    SolveArm<SrsArm> exact, near;
    double (*swivel_of)(const SrsArm&, const double (&q)[7]);
};

}  // namespace urdf_ik
