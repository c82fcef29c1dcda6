// All curves of joint vectors that hold a pose, and the intervals of the redundancy parameter in which each branch stays
// inside the joint limits.
//
// All solutions at the values of a grid are given. From each of them the curve is followed by its arc to the next value of
// the grid, or round a fold back to the first one; every solution must be met from both sides, by one curve each, else the
// cell is followed again by shorter steps. A solution that is met and was not given is followed on. Loops that lie between two
// values of the grid are searched for by Newton's method from starts all over the joint space.
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "self_motion/curve_arm.hpp"

namespace urdf_ik {

// Why an interval ends.
enum class EndOf : int { nothing, fold, reach, singularity, lower_limit, upper_limit, range };

struct CurveSample {
    double q[7], along[7];  // the tangent points the way in which the value grows
    double value, rate;     // of the parameter, on without a jump; its derivative by the arc
    double arc;             // from the sample before [rad, shares of size]
    int sense;              // with that tangent; see OnCurve
};

struct Interval {
    long pose, first, count;  // samples, of growing value: the first and the last are the ends
    int column;               // of the solver, in the middle; -1: none of the given solutions is in it
    EndOf why[2];
    int joint[2];  // whose limit it is, or -1
};

struct Intervals {
    std::vector<CurveSample> samples;
    std::vector<Interval> found;
    // Of parts that hold no given solution: the pose, and a value in its middle. Other branches may have such parts there, too.
    std::vector<std::pair<long, double>> unseen;
};

// The input for one pose.
struct GridOfSolutions {
    const double* T;              // (4, 4)
    const double* grid;           // (values) ascending
    long values;
    bool round;                   // whether the value after the last is the first, a turn on
    const double* q;              // (values, branches, 7)
    const std::uint8_t* flags;    // (values, branches) bit 0: valid
    int branches;
    const double *lower, *upper;  // (7) limits; infinite where there is none
    // All branches at more values, which are as round as the grid's, beyond their ends too, not verified; null: none are known.
    const double* beyond;  // (fine, branches, 7)
    long fine;
    double off;  // error below which these are solutions
    const double* starts;  // (count, 7) joint vectors for the search for loops
    int count;
};

namespace self_motion {
inline constexpr double PI = 3.141592653589793, TURN = 2.0 * PI;

inline double wrapped(double a) {
    if (a > PI) a -= TURN * std::ceil((a - PI) / TURN);
    else if (a <= -PI) a += TURN * std::ceil((-PI - a) / TURN + (a == -PI ? 1.0 : 0.0));
    return a;
}
}  // namespace self_motion

// From one value of a joint to another, the shorter way round [rad, shares of size].
inline double gap_of(const FreeArm& arm, int joint, double to, double from) {
    return arm.written.slides[joint] ? (to - from) / arm.unit[joint] : self_motion::wrapped(to - from);
}

// The cubic through two neighbouring samples with their tangents, at a share of the way: a joint vector near the curve, and the
// tangent times the arc where it is asked for.
void interpolate(const FreeArm& arm, const CurveSample& a, const CurveSample& b, double share, double* q, double* along = nullptr);

void follow_curves(const FreeArm& arm, const SelfMotionFunctions& core, const GridOfSolutions& given, long pose, Intervals& to);

}  // namespace urdf_ik
