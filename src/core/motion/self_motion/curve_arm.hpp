// The self-motion of seven joints: the curve of joint vectors that hold one pose.
#pragma once

#include "arm/arm.hpp"

namespace urdf_ik {

struct FreeArm {
    Written<7> written;
    int given;  // the joint whose value is the redundancy parameter; -1: the swivel angle of an S-R-S arm
    Ends ends;  // for the swivel angle: frame 1 is at the shoulder, the tool point is the wrist
    // For each joint: 1 if it slides, else 0; its unit along a curve [rad, m]. The eighth entry is padding.
    double slides[8], unit[8];
};

// A further condition on a point of the curve.
enum class Pin : std::uint8_t { nothing, joint, parameter };
struct Pinned {
    Pin what;
    int joint;
    double value;  // [rad, m]
};

// A joint vector near the curve.
struct Start {
    const double* T;  // the pose (4, 4)
    double q[7];
    Pinned pin;
    int rounds;     // greatest number of rounds of Newton's method
    double enough;  // error at which it stops
};

// A point on the curve. Directions and lengths along it are in rad for joints that turn, in shares of the size for slides.
struct OnCurve {
    double q[7];      // angles in (-pi, pi]
    double along[7];  // unit tangent, of either sense
    double value;     // of the parameter [rad, m]
    double rate;      // derivative of the parameter along the tangent
    double moved;     // distance by which Newton's method moved the point
    double left;      // the remaining error
    // Sign of the determinant of the Jacobian's rows and the tangent; constant along a curve, 0 at a singularity.
    int sense;
};

// Error at which a search for points of the curve stops. A rate of the parameter below it is zero: the parameter is stationary
// along the tangent, at a fold, or where the other joints move at one value.
inline constexpr double NEARLY_EXACT = 1e-9;

struct SelfMotionFunctions {
    // The points on the curve near starts (count), by Newton's method with minimum-norm steps; a pin adds an equation. They are
    // computed side by side.
    void (*settle)(const FreeArm&, const Start*, int count, OnCurve* to);
    // Newton's method from each of starts (count, 7). Writes the points that converged to q (count, 7); returns their number.
    int (*search)(const FreeArm&, const double* T, const double* starts, int count, double* q);
    // The pose errors of joint vectors (count, 7), see pose_error [rad, share of size]. A NaN among the joints gives NaN.
    void (*errors)(const FreeArm&, const double* T, const double* q, long count, double* to);
};

}  // namespace urdf_ik
