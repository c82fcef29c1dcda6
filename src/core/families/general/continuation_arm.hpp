// Poses of an arm of six joints at which all of its solutions are known, the complex ones included.
#pragma once

namespace urdf_ik {

// Of each joint e^(i angle), or its length in sizes of the arm: real and imaginary part.
struct ComplexJoints {
    double z[6][2];
};

// A pose is that of joint 6's frame, after the joint has moved, in joint 1's frame before it moves.
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
