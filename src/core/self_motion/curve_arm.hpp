// The self-motion of seven joints: the curve of joint vectors that hold one pose.
#pragma once

#include "kinematics/arm.hpp"

namespace urdf_ik {

struct FreeArm {
    Written<7> written;
    int given;  // the joint whose value is the redundancy parameter; -1: the swivel angle of an S-R-S arm
    Ends ends;  // of that angle: frame 1 stands in the shoulder, the tool's point is the wrist
    // For each joint: 1 if it slides, else 0; its unit along a curve [rad, m]. The eighth entry is for no joint.
    double slides[8], unit[8];
};

// A further condition on a point of the curve.
enum class Pin : std::uint8_t { nothing, joint, parameter };
struct Pinned {
    Pin what;
    int joint;
    double value;  // [rad, m]
};

// A point on the curve. Directions and lengths along it: joints in rad, or in shares of the size for those that slide.
struct OnCurve {
    double q[7];      // angles in (-pi, pi]
    double along[7];  // unit tangent, of either sense
    double value;     // of the parameter [rad, m]
    double rate;      // by which it changes along the tangent
    double moved;     // how far Newton's method has moved the point
    double left;      // the error where it stopped
    // Sign of the determinant of the Jacobian's rows and the tangent; 0 at a singularity. Along a curve it stays as it is.
    int sense;
};

struct SelfMotionFunctions {
    // The point on the curve next to q, by Newton's method of least steps, or the one with what is pinned; at most so many
    // rounds, and no more than an error of `enough` takes.
    OnCurve (*settle)(const FreeArm&, const double* T, const double* q, const Pinned&, int rounds, double enough);
    // Points on the curve from starts (count, 7), of which those with NaN are left out, to q (count, 7); returns how many.
    int (*search)(const FreeArm&, const double* T, const double* starts, int count, double* q);
    // How far joint vectors (count, 7) are from the pose [rad, share of size]: the greatest entry of the twist between, 2 beyond
    // 60 degrees, NaN where one is.
    void (*errors)(const FreeArm&, const double* T, const double* q, long count, double* to);
};

}  // namespace urdf_ik
