// All curves of joint vectors that hold a pose, and the intervals of the redundancy parameter in which each branch stays
// inside the joint limits.
//
// The caller gives all solutions at the values of a grid. From each solution the follower takes steps of arc length along its
// curve, to the next value of the grid or round a fold back to the same value. Exactly one curve must meet each solution from
// each side; otherwise the follower repeats the cell with shorter steps. If a curve meets a solution that was not given, the
// follower goes on from it. Loops that lie between two values of the grid are found by Newton's method from many starts.
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "motion/self_motion/curve_arm.hpp"
#include "numbers/angles.hpp"

namespace urdf_ik {

// Why an interval ends.
enum class EndOf : int { nothing, fold, reach, singularity, lower_limit, upper_limit, range };

struct CurveSample {
    double value, rate;     // of the parameter, continuous along the curve; its derivative by arc length
    double arc;             // arc length from the previous sample [rad, shares of size]
    double q[7], along[7];  // the tangent points towards growing values
    int sense;              // with that tangent; see OnCurve
};

struct Interval {
    long pose, first, count;  // samples in order of their values: the first and the last are the ends
    int column;               // of the given solution nearest to the middle; -1: no given solution lies in the interval
    EndOf why[2];
    int joint[2];  // whose limit it is, or -1
};

struct Intervals {
    std::vector<CurveSample> samples;
    std::vector<Interval> found;
    // For each curve without a given solution: the pose, and a value near the curve's middle.
    std::vector<std::pair<long, double>> unseen;
};

// The input for one pose.
struct GridOfSolutions {
    const double* T;              // (4, 4)
    const double* grid;           // (values) ascending
    long values;
    bool round;                   // whether the grid is periodic: the first value follows the last, one turn on
    const double* q;              // (values, branches, 7)
    const std::uint8_t* flags;    // (values, branches) bit 0: valid
    int branches;
    const double *lower, *upper;  // (7) limits; infinite for a joint without limits
    // The closed form's branches at more values, unverified, also beyond their ends; null if unknown. Periodic if `round`.
    const double* beyond;  // (fine, branches, 7)
    long fine;
    double off;  // pose error up to which these count as solutions
    const double* starts;  // (count, 7) joint vectors for the search for loops
    int count;
};

// Joint value `to` minus `from`, angles the shorter way round [rad, shares of size].
inline double gap_of(const FreeArm& arm, int joint, double to, double from) {
    return arm.written.slides[joint] ? (to - from) / arm.unit[joint] : principal_angle(to - from);
}

// The cubic Hermite interpolant of a number along a step, less the number at its beginning, by the share of the way.
struct Cubic {
    double first, second, third;  // factors of the powers of the share
    // change: over the whole step; begin, end: derivatives by the share there.
    Cubic(double change, double begin, double end)
        : first(begin), second(3.0 * change - 2.0 * begin - end), third(begin + end - 2.0 * change) {}
    double at(double u) const { return u * (first + u * (second + u * third)); }
    double slope(double u) const { return first + u * (2.0 * second + 3.0 * u * third); }
    // The two shares at which the slope is zero; NaN if it is nowhere.
    std::pair<double, double> level() const {
        const double sum = -(second + std::copysign(std::sqrt(second * second - 3.0 * third * first), second));
        return {sum / (3.0 * third), first / sum};
    }
};
inline Cubic joint_on(const FreeArm& arm, int joint, const CurveSample& a, const CurveSample& b) {
    return {gap_of(arm, joint, b.q[joint], a.q[joint]), b.arc * a.along[joint], b.arc * b.along[joint]};
}
inline Cubic value_on(const CurveSample& a, const CurveSample& b) { return {b.value - a.value, b.arc * a.rate, b.arc * b.rate}; }

// The joint vector near the curve between two neighbouring samples at a share of the way and, unless `along` is null, its
// derivative by the share.
void interpolate(const FreeArm& arm, const CurveSample& a, const CurveSample& b, double share, double* q, double* along = nullptr);

void follow_curves(const FreeArm& arm, const SelfMotionFunctions& core, const GridOfSolutions& given, long pose, Intervals& to);

}  // namespace urdf_ik
