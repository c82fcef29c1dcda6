// The state of a tracked arm, its error to the target, and the least-squares step inside a cycle's bounds.
#pragma once

#include "arm/target.hpp"
#include "motion/tracker_arm.hpp"
#include "propose/polish.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Damping of the tracker's steps. It does not change a solution, and avoids a division by zero.
inline constexpr double FAINT = 1e-9;
// If the sine of the rotation to the goal is above this, the angle is computed by atan2. Below, the Newton step's sine is used.
inline constexpr double SMALL_TURN = 0.1;

// The arm at one joint vector, and its error to a goal. Lengths are shares of the size.
template <int N> struct Stand {
    double q[N];
    Posture<N, double> at;
    Six<double> J[N], twist;
    double square, size;  // of the twist: squared length; largest entry, or 2 beyond a right angle
};

// The bounds of the joints in this cycle [rad, m]. limit_below, limit_above: a bit per joint whose bound is a joint limit.
template <int N> struct Box {
    double low[N], high[N];
    unsigned limit_below, limit_above;
};

template <int N> STEP double unit_of(const Written<N>& arm, int k) { return arm.slides[k] ? arm.size : 1.0; }

template <int N> PART void place_at(const Written<N>& arm, Stand<N>& s) {
    double q[N];
    for (int k = 0; k < N; ++k) q[k] = arm.slides[k] ? s.q[k] : s.q[k] - 2.0 * PI * __builtin_floor(s.q[k] / (2.0 * PI) + 0.5);
    s.at = place(arm, q);
    jacobian_at(arm, s.at, s.J);
}

// The axis of a half turn to the goal. If the task aims an axis, any axis across it.
template <int N> PART Vec<double> half_turn_axis(const Written<N>& arm, const Goal<double>& goal, const Frame<double>& tip) {
    if (arm.task == Task::planar_pose) return vec<double>(arm.normal);
    const Rot<double>&G = goal.R, &R = tip.R;
    const Vec<double> along = tip.R * vec<double>(arm.aimed);
    const bool aims = N < 6 && arm.task == Task::position_and_axis;
    // Columns of the symmetric matrix M + 1, or of 1 - a a': multiples of the axis, or across a.
    const Vec<double> column[3] = {
        aims ? without({1.0, 0.0, 0.0}, along) : R.x.x * G.x + R.y.x * G.y + R.z.x * G.z + Vec<double>{1.0, 0.0, 0.0},
        aims ? without({0.0, 1.0, 0.0}, along) : R.x.y * G.x + R.y.y * G.y + R.z.y * G.z + Vec<double>{0.0, 1.0, 0.0},
        aims ? without({0.0, 0.0, 1.0}, along) : R.x.z * G.x + R.y.z * G.y + R.z.z * G.z + Vec<double>{0.0, 0.0, 1.0}};
    int longest = 0;
    for (int i = 1; i < 3; ++i) longest = dot(column[i], column[i]) > dot(column[longest], column[longest]) ? i : longest;
    return (1.0 / sqrt(dot(column[longest], column[longest]))) * column[longest];
}

// The error to the goal as for Newton's method, but a large rotation enters with its angle instead of its sine.
template <int N> PART void face(const Written<N>& arm, const Goal<double>& goal, Stand<N>& s) {
    const Error<double> e = task_error(arm, goal, s.at.tip);
    const bool obtuse = e.size == 2.0;
    s.twist = e.twist, s.size = e.size;
    const Vec<double> w = {e.twist[3], e.twist[4], e.twist[5]};
    const double sine = sqrt(dot(w, w));
    if (obtuse || sine > SMALL_TURN) {
        const double cosine = sqrt(max(0.0, 1.0 - sine * sine)), angle = atan2(sine, obtuse ? -cosine : cosine);
        const Vec<double> turn = sine > FAINT ? (angle / sine) * w : angle * half_turn_axis(arm, goal, s.at.tip);
        s.twist[3] = turn.x, s.twist[4] = turn.y, s.twist[5] = turn.z;
    }
    s.square = dot(s.twist, s.twist);
}

// The pose after a share of a twist from the tip.
PART Goal<double> between(const Frame<double>& tip, const Six<double>& twist, double share, double size) {
    const Vec<double> v = {twist[0], twist[1], twist[2]}, w = {twist[3], twist[4], twist[5]};
    const double angle = sqrt(dot(w, w)) + TINY;
    return {turned_about(tip.R, (1.0 / angle) * w, cos_sin(share * angle)), tip.p + (share * size) * v};
}

// The length of a twist's linear (0) or angular part (3).
STEP double length(const Six<double>& twist, int part) {
    return sqrt(twist[part] * twist[part] + twist[part + 1] * twist[part + 1] + twist[part + 2] * twist[part + 2]);
}

// The joint vector moved by x.
template <int N> PART Stand<N> moved(const Written<N>& arm, const Stand<N>& from, const double (&x)[N]) {
    Stand<N> to;
    for (int k = 0; k < N; ++k) to.q[k] = from.q[k] + unit_of(arm, k) * x[k];
    place_at(arm, to);
    return to;
}
template <int N> STEP double longest(const double (&x)[N]) {
    double most = 0.0;
    for (const double each : x) most = max(most, abs(each));
    return most;
}
template <int N> STEP double apart(const Written<N>& arm, const Stand<N>& a, const Stand<N>& b) {
    double most = 0.0;
    for (int k = 0; k < N; ++k) most = max(most, abs(a.q[k] - b.q[k]) / unit_of(arm, k));
    return most;
}

template <int N> struct BoundedStep {
    double x[N];
    unsigned below, above;  // which joints are at their bounds
    double left;            // squared length of the remaining e
    double least;           // a lower bound on the smallest singular value of J, with the damping
};

// The x between the bounds that approximately minimises |J x - e|. While a joint exceeds its bounds, the one that exceeds them
// most is fixed at its bound, and the problem is solved again for the other joints.
template <int N>
PART BoundedStep<N> bounded_step(const Six<double> (&J)[N], Six<double> e, double damping, const double (&low)[N],
                                 const double (&high)[N]) {
    BoundedStep<N> out = {};
    for (;;) {
        Six<double> A[N];
        for (int k = 0; k < N; ++k) {
            if ((out.below | out.above) >> k & 1) A[k] = {};
            else A[k] = J[k];
        }
        const Solved<N, double> s = damped_step(A, e, damping);
        if (!(out.below | out.above)) out.least = s.least;
        int worst = -1;
        double most = 0.0;
        for (int k = 0; k < N; ++k) {
            if ((out.below | out.above) >> k & 1) continue;
            const double over = max(s.x[k] - high[k], low[k] - s.x[k]);
            if (over > most) most = over, worst = k;
        }
        if (worst < 0) {
            for (int k = 0; k < N; ++k) {
                if ((out.below | out.above) >> k & 1) continue;
                out.x[k] = s.x[k], e = less(e, s.x[k], J[k]);
            }
            out.left = dot(e, e);
            return out;
        }
        const bool up = s.x[worst] > high[worst];
        out.x[worst] = up ? high[worst] : low[worst];
        (up ? out.above : out.below) |= 1u << worst;
        e = less(e, out.x[worst], J[worst]);
    }
}

// The rows of J.
template <int N> STEP void transpose(const Six<double> (&J)[N], Rows<N, double> (&rows)[6]) {
    for (int i = 0; i < 6; ++i) {
        for (int k = 0; k < N; ++k) rows[i][k] = J[k][i];
    }
}

// A lower bound on the smallest singular value of J (for seven joints, of its transpose).
template <int N> PART double least_gain(const Six<double> (&J)[N]) {
    if constexpr (N <= 6) {
        Six<double> A[N];
        for (int k = 0; k < N; ++k) A[k] = J[k];
        return damped_step(A, Six<double>{}, FAINT).least;
    } else {
        Rows<N, double> A[6];
        transpose(J, A);
        return damped_step(A, Rows<N, double>{}, FAINT).least;
    }
}

}  // namespace urdf_ik::URDF_IK_LEVEL
