// Poses of an arm of six joints at which all of its solutions are known, the complex ones included.
#pragma once

namespace urdf_ik {

// For each joint the real and imaginary part of e^(i angle), or of a slide's length in sizes of the arm.
struct ComplexJoints {
    double z[6][2];
};

// The pose of joint 6's frame after the joint has moved, in joint 1's frame before it moves.
struct KnownPose {
    static constexpr int most = 16;
    double turn[4], point[3];  // unit quaternion (real part first), position [m]
    ComplexJoints solution[most];
};

struct Continuation {
    static constexpr int most = 16;
    int solutions, poses;  // solutions of every pose, poses
    KnownPose known[most];
};

}  // namespace urdf_ik
