// Newton's method on the arm as written in doubles, for one to seven joints that turn or slide, for one candidate or a block of
// candidates side by side. Certificates have steps of their own (single.hpp).
//
// A Model is the arm as written (Written<N>), or another type with `joints`, `rows`, `tolerances` and its own versions of the
// functions below: arms whose joints drive several axes, and arms with further constraints beside the pose.
#pragma once

#include "arm/kinematics.hpp"
#include "numbers/least_squares.hpp"
#include "numbers/thresholds.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The target: the frame of the tip in the base.
template <class V> using Goal = Frame<V>;

STEP Goal<double> goal_of(const double* T) {
    return {{{T[0], T[4], T[8]}, {T[1], T[5], T[9]}, {T[2], T[6], T[10]}}, {T[3], T[7], T[11]}};
}
template <class V> STEP Vec<V> spread(const Vec<double>& a) { return {V(a.x), V(a.y), V(a.z)}; }
template <class V> STEP Goal<V> spread(const Goal<double>& g) {
    return {{spread<V>(g.R.x), spread<V>(g.R.y), spread<V>(g.R.z)}, spread<V>(g.p)};
}

// The twist from the tip to the goal, lengths as shares of the size, and its largest entry.
template <class V, int rows = 6> struct Error {
    Rows<rows, V> twist;
    V size;
};

// The rotational part is the vector of the skew part of goal R^T, exact to second order. It also vanishes at half a turn, which
// the trace detects.
template <class V> STEP Error<V> pose_error(const Goal<V>& goal, const Frame<V>& tip, double inverse_size) {
    const Vec<V> p = V(inverse_size) * (goal.p - tip.p);
    const Rot<V>&G = goal.R, &R = tip.R;
    const Vec<V> w = V(0.5) * (cross(R.x, G.x) + cross(R.y, G.y) + cross(R.z, G.z));
    Error<V> e = {{{p.x, p.y, p.z, w.x, w.y, w.z}}, V(0.0)};
    const V trace = dot(R.x, G.x) + dot(R.y, G.y) + dot(R.z, G.z);
    e.size = select(trace > V(1.0), largest(e.twist), 2.0);
    return e;
}

template <class V> STEP Vec<V> without(const Vec<V>& a, const Vec<V>& n) { return a - dot(n, a) * n; }

// The same, restricted to what the arm's task controls.
template <int N, class V> STEP Error<V> task_error(const Written<N>& arm, const Goal<V>& goal, const Frame<V>& tip) {
    const double inverse_size = 1.0 / arm.size;
    if (N >= 6 || arm.task == Task::pose) return pose_error(goal, tip, inverse_size);
    Vec<V> p = V(inverse_size) * (goal.p - tip.p), w = {V(0.0), V(0.0), V(0.0)};
    const Vec<V> normal = vec<V>(arm.normal);
    V ahead = 1.0;
    if (arm.task == Task::planar_position || arm.task == Task::planar_pose) p = without(p, normal);
    if (arm.task == Task::position_and_axis || arm.task == Task::planar_pose) {
        Vec<V> now = tip.R * vec<V>(arm.aimed), wanted = goal.R * vec<V>(arm.aimed);
        if (arm.task == Task::planar_pose) now = without(now, normal), wanted = without(wanted, normal);
        w = cross(now, wanted);
        ahead = dot(now, wanted);
    }
    Error<V> e = {{{p.x, p.y, p.z, w.x, w.y, w.z}}, V(0.0)};
    e.size = select(ahead > V(0.0), largest(e.twist), 2.0);
    return e;
}

// A column of the geometric Jacobian, restricted to what the arm's task controls.
template <int N, class V> STEP Six<V> task_column(const Written<N>& arm, const Frame<V>& tip, const Six<V>& column) {
    if (N >= 6 || arm.task == Task::pose) return column;
    Vec<V> v = {column[0], column[1], column[2]}, w = {column[3], column[4], column[5]};
    const Vec<V> normal = vec<V>(arm.normal);
    if (arm.task == Task::position || arm.task == Task::planar_position) w = {V(0.0), V(0.0), V(0.0)};
    if (arm.task == Task::position_and_axis) w = without(w, tip.R * vec<V>(arm.aimed));
    if (arm.task == Task::planar_pose) w = dot(normal, w) * normal;
    if (arm.task == Task::planar_position || arm.task == Task::planar_pose) v = without(v, normal);
    return {{v.x, v.y, v.z, w.x, w.y, w.z}};
}

// The error at q, without derivatives.
template <int N, class V> STEP Error<V> error_at(const Written<N>& arm, const Goal<V>& goal, const V (&q)[N]) {
    return task_error(arm, goal, place(arm, q).tip);
}

// The columns of the task's Jacobian.
template <int N, class V> STEP void jacobian_at(const Written<N>& arm, const Posture<N, V>& at, Six<V> (&J)[N]) {
#pragma GCC unroll 1
    for (int k = 0; k < N; ++k) {
        J[k] = task_column(arm, at.tip, jacobian_column(at.joint[k], arm.slides[k], at.tip.p, 1.0 / arm.size));
    }
}

// The error at q, and the Jacobian's columns: by rad, or by shares of the size for joints that slide.
template <int N, class V>
STEP Error<V> error_and_jacobian(const Written<N>& arm, const Goal<V>& goal, const V (&q)[N], Six<V> (&J)[N]) {
    const Posture<N, V> at = place(arm, q);
    jacobian_at(arm, at, J);
    return task_error(arm, goal, at.tip);
}

// Joint k's value q_k after a step of x (rad, or shares of the size).
template <int N, class V> STEP V advanced(const Written<N>& arm, int k, const V& q, const V& x) {
    return arm.slides[k] ? q + arm.size * x : wrap(q + x);
}
// The difference of two values of joint k (rad, or shares of the size), the shorter way round.
template <int N> STEP double gap(const Written<N>& arm, int k, double a, double b) {
    return arm.slides[k] ? (a - b) / arm.size : wrap(a - b);
}

// The conditions at which an iteration stops.
struct Course {
    int rounds;             // greatest number of rounds
    double enough;          // stop below this error
    int patience;           // stop after this many rounds in which the error has not fallen by a third
    double least_damping = VANISHING;
};

// At a singular solution, and in a valley: without the damping HELD rounding would move the arm along its singular direction.
inline constexpr Course ACROSS_A_VALLEY = {8, FINISHED, LONG_PATIENCE, HELD};

// The result. The joint vector that was passed in is replaced by the best one found.
template <class V> struct Polished {
    V error;  // at the best joint vector
    V least;  // a lower bound on the Jacobian's smallest singular value, where the last step began
};

// The error and the columns of the Jacobian at q; and the damped least-squares solution of J x = e, whose J is overwritten: calls
// for one joint vector, in place for a block.
template <class Model>
SHARED Error<double, Model::rows> derivatives_at(const Model& arm, const Goal<double>& goal, const double (&q)[Model::joints],
                                                 Rows<Model::rows, double> (&J)[Model::joints]) {
    return error_and_jacobian(arm, goal, q, J);
}
template <class Model, int L, int K>
STEP auto derivatives_at(const Model& arm, const Goal<Pack<L, K>>& goal, const Pack<L, K> (&q)[Model::joints],
                         Rows<Model::rows, Pack<L, K>> (&J)[Model::joints]) {
    return error_and_jacobian(arm, goal, q, J);
}
template <int N, int rows> PART Solved<N, double> damped_step(Rows<rows, double> (&J)[N], const Rows<rows, double>& e,
                                                              double damping) {
    return least_squares<true>(J, e, damping);
}

// Newton's method from q, which is replaced by the best vector found. Steps are limited to half a radian.
// Damped: the damping falls with the error, so that convergence is quadratic at regular solutions and steps stay bounded at
// singular ones. Undamped: for starts near regular solutions, about a third faster.
// Lanes in which `moves` does not hold are left unchanged.
template <bool damped, class Model, class V>
STEP Polished<V> polish(const Model& arm, const Goal<V>& goal, V (&q)[Model::joints], const Course& course,
                        MaskOf<V> moves = V(0.0) <= V(0.0)) {
    constexpr int N = Model::joints;
    Polished<V> out = {V(__builtin_inf()), V(0.0)};
    V best[N], mark = __builtin_inf(), since = 0.0;
    for (int j = 0; j < N; ++j) best[j] = q[j];
    for (int round = 0;; ++round) {
        Rows<Model::rows, V> J[N];
        const Error<V, Model::rows> e = error_and_jacobian(arm, goal, q, J);
        const auto better = moves & (e.size < out.error);
        // Below CONVERGED, a step that does not halve the error ends the iteration.
        const auto settled = (min(out.error, e.size) < V(CONVERGED)) & !(e.size < 0.5 * out.error);
        for (int j = 0; j < N; ++j) best[j] = select(better, q[j], best[j]);
        out.error = select(better, e.size, out.error);
        const auto gained = e.size < 0.7 * mark;
        mark = select(gained, e.size, mark);
        since = select(gained, V(0.0), since + 1.0);
        moves = moves & (e.size >= V(course.enough)) & !settled & (since <= V(double(course.patience)));
        const bool rests = round == course.rounds || !any(moves);
        if (rests && round > 0) break;
        V damping = min(1e-2 * e.size, V(1e-2)) + course.least_damping;
        if constexpr (damped) damping = select(better | (e.size >= V(HALF_OF_THE_DIGITS)), damping, max(damping, V(HELD)));
        Solved<N, V> step;
        if constexpr (damped && lanes_of<V> == 1 && N > 4) step = damped_step(J, e.twist, damping);
        else step = least_squares<damped>(J, e.twist, damping);
        out.least = select(better & (moves | (V(double(round)) < V(0.5))), step.least, out.least);
        if (rests) break;
        V longest = TINY;
        for (int j = 0; j < N; ++j) longest = max(longest, abs(step.x[j]));
        const V shrink = min(0.5 / longest, V(1.0));
        for (int j = 0; j < N; ++j) q[j] = select(moves, advanced(arm, j, q[j], shrink * step.x[j]), q[j]);
    }
    for (int j = 0; j < N; ++j) q[j] = best[j];
    return out;
}

// The same as a call, for a block of candidates, and for one.
template <bool damped, class Model>
SHARED Polished<Block> polish_block(const Model& arm, const Goal<Block>& goal, Block (&q)[Model::joints], const Course& course,
                                    const MaskOf<Block>& moves = Block(0.0) <= Block(0.0)) {
    return polish<damped>(arm, goal, q, course, moves);
}
template <bool damped, class Model>
SHARED Polished<double> polish_one(const Model& arm, const Goal<double>& goal, double (&q)[Model::joints], const Course& course) {
    return polish<damped>(arm, goal, q, course);
}

}  // namespace urdf_ik::URDF_IK_LEVEL
