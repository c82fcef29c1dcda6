// The loop equation of six turning joints, and what rounding makes of it.
//
// The joints are q, the steps between them S (arm.hpp), the target T, and Z_k turns about the z axis of joint k's frame by q_k.
// In the frame of joint 4, with G = S_0^-1 T S_6^-1, a solution is a joint vector with
//   X(q) = S_3^-1 Z_3^-1 S_2^-1 Z_2^-1 S_1^-1 Z_1^-1 G Z_6^-1 S_5^-1 Z_5^-1 S_4^-1 Z_4^-1 = 1.
// There joint k has a twist zeta_k = (p x w, w), with its axis w through the point p, so that
//   Y(d) = exp(zeta_1 d_1) ... exp(zeta_6 d_6) = X(q)     exactly where q + d is a solution.
// Let V of a motion be its position and the vector of its rotation's skew part. The map f(d) = V(Y(d)) - V(X(q)) has at d = 0 the
// value -V(X), the derivative (zeta_1 ... zeta_6) and the second derivatives (w_i x v_j, w_i x w_j / 2), i <= j, exactly. A zero of
// f is a solution: two rotations with equal skew parts are equal if both traces are less than one away from 3, as the cosine of
// the angle, (trace - 1) / 2, is a root of 1 - |skew part|^2 with a positive real part.
//
// In the middle of the loop no twist is a product of more than three turns. Angles may be complex; z = e^(i angle). Lengths are
// shares of the arm's size.
//
// Rounding. u is the unit roundoff, M_k = e^|Im q_k| the 2-norm of a turn, M the product of all six. Errors are measured in the
// Frobenius norm, which is at most sqrt(3) M for X's rotation.
// - A cosine and a sine from z are off by 3 u M_k each; a product of complex numbers is off by sqrt(5) u at most. Turning two
//   columns then adds (6 + sqrt(2) (sqrt(5) + 1)) u M_k < 10.6 u M_k times the norm.
// - A step adds 3 u times the norms of the absolute values, which is at most 3 sqrt(3) u < 5.2 u times the norm.
// - Six turns and six steps: sqrt(3) 6 (10.6 + 5.2) u M < 165 u M. G is a product of three rotations, 6 sqrt(3) sqrt(3) u, and
//   they and the five steps are orthogonal to 4 u each: less than 50 u M. Together 215 u M.
// - The skew part's vector is at most 1 / sqrt(2) of that, and is half a difference: less than 155 u M.
// - The step behind k turns has a rotation that is off by less than (28 k + 50) u M so far, which turns its length; its product
//   adds 3 sqrt(3) u, and six sums 6 u: the position is off by less than sum_k (28 k + 62) u M times the step's length.
// - The position of G is a sum of those of T, S_0 and S_6, which may cancel: each is scaled, 2 u, turned at most three times, 3
//   sqrt(3) u each, added twice, 2 u each, by rotations that are orthogonal to 4 u: less than 30 u times its length.
// - A twist's axis and point come from at most three of the turns, with norms up to m, the larger product of M_1 M_2 M_3 and
//   M_4 M_5 M_6, and from lengths of sum l: its error is below 100 u m^2 (2 l + 1).
#pragma once

#include "arm/kinematics.hpp"
#include "numbers/complex.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

using CBlock = Complexes<Block>;

// The counts above, times u.
inline constexpr double UNIT = 1.1102230246251565e-16;
inline constexpr double ROUNDING_OF_ROTATION = 155.0 * UNIT, ROUNDING_OF_TWIST = 100.0 * UNIT;
inline constexpr double ROUNDING_A_TURN = 28.0 * UNIT, ROUNDING_OF_STEP = 62.0 * UNIT, ROUNDING_OF_TARGET = 30.0 * UNIT;

// Real and complex blocks alike: V is Block or CBlock.
STEP Block conj(const Block& a) { return a; }
STEP Block square(const Block& a) { return a * a; }
STEP Block scaled(const Block& f, const Block& a) { return f * a; }
// An upper bound on |a|, at most 8.3 % too large, without a root: the larger part, and tan(pi / 8) of the smaller.
STEP Block above(const Block& a) { return abs(a); }
STEP Block above(const CBlock& a) {
    const Block x = abs(a.re), y = abs(a.im);
    return max(x, y) + 0.41421357 * min(x, y);
}

// The loop of one pose: inverse steps, G, two of the steps themselves, l, and the rounding of X's position over M.
template <class M> struct LoopOf {
    M third, second, first, goal, fifth, fourth, ahead[2];
    double length = 0.0, rounding = 0.0;
};
using Loop = LoopOf<Motion>;

// The loop of these steps and this target, lengths as shares of the size.
template <class M> STEP LoopOf<M> loop_of_steps(const M (&step)[7], const M& target) {
    return {inverse_of(step[3]), inverse_of(step[2]),
            inverse_of(step[1]), composed(inverse_of(step[0]), composed(target, inverse_of(step[6]))),
            inverse_of(step[5]), inverse_of(step[4]),
            {step[4], step[5]}};
}

PART Loop loop_of(const Written<6>& arm, const Frame<double>& goal) {
    const auto scaled = [&](Motion m) {
        for (double& x : m.t) x *= 1.0 / arm.size;
        return m;
    };
    Motion step[7];
    for (int k = 0; k < 7; ++k) step[k] = scaled(arm.step[k]);
    const Motion target = scaled(motion_of(goal));
    Loop loop = loop_of_steps(step, target);
    const auto length_of = [](const Motion& m) { return sqrt(m.t[0] * m.t[0] + m.t[1] * m.t[1] + m.t[2] * m.t[2]); };
    int turns = 0;
    const auto add = [&](const Motion& m) {
        const double length = length_of(m);
        loop.length += length, loop.rounding += (ROUNDING_OF_STEP + ROUNDING_A_TURN * turns++) * length;
    };
    loop.rounding = ROUNDING_OF_TARGET * (length_of(step[0]) + length_of(target) + length_of(step[6]));
    add(loop.third), add(loop.second), add(loop.first), add(loop.goal), add(loop.fifth), add(loop.fourth);
    return loop;
}

// The loop at q: twists, V(X), and the distance of X's trace from 3.
template <class V> struct LoopAt {
    Six<V> twist[6], error;
    V off;
};

// The joint's twist: its axis is the z axis of the frame.
template <class V> STEP Six<V> twist_of(const Frame<V>& at) {
    const Vec<V>& w = at.R.z;
    const Vec<V> v = cross(at.p, w);
    return {{v.x, v.y, v.z, w.x, w.y, w.z}};
}
template <class V> STEP Turn<V> back(const Turn<V>& t) { return {t.c, -t.s}; }
// The frame turned back about its z axis, then moved by a step.
template <class V, class M> STEP Frame<V> turned_back(const Frame<V>& at, const Turn<V>& t, const M& step) {
    return beyond(turned(at, back(t)), step);
}

template <class V, class M> PART LoopAt<V> loop_at(const LoopOf<M>& loop, const Turn<V> (&turn)[6]) {
    LoopAt<V> out;
    Frame<V> at = constant_frame<V>(loop.third);
    out.twist[2] = twist_of(at);
    at = turned_back(at, turn[2], loop.second);
    out.twist[1] = twist_of(at);
    at = turned_back(at, turn[1], loop.first);
    out.twist[0] = twist_of(at);
    at = turned_back(at, turn[0], loop.goal);
    at = turned_back(at, turn[5], loop.fifth);
    at = turned_back(at, turn[4], loop.fourth);
    const Frame<V> X = turned(at, back(turn[3]));
    // Joints 4, 5 and 6 from the other side.
    const V zero = 0.0, one = 1.0;
    Frame<V> side = {{{one, zero, zero}, {zero, one, zero}, {zero, zero, one}}, {zero, zero, zero}};
    out.twist[3] = {{zero, zero, zero, zero, zero, one}};
    side = beyond(turned(side, turn[3]), loop.ahead[0]);
    out.twist[4] = twist_of(side);
    side = beyond(turned(side, turn[4]), loop.ahead[1]);
    out.twist[5] = twist_of(side);
    const Rot<V>& R = X.R;
    out.error = {{X.p.x, X.p.y, X.p.z, 0.5 * (R.y.z - R.z.y), 0.5 * (R.z.x - R.x.z), 0.5 * (R.x.y - R.y.x)}};
    out.off = R.x.x + R.y.y + R.z.z - V(3.0);
    return out;
}

// Turns from complex numbers on the joints' circles, or from real angles.
STEP void turns_of(const CBlock (&z)[6], Turn<CBlock> (&turn)[6]) {
    for (int k = 0; k < 6; ++k) turn[k] = turn_of(z[k]);
}
STEP void turns_of(const Block (&q)[6], Turn<Block> (&turn)[6]) {
    for (int k = 0; k < 6; ++k) turn[k] = cos_sin(q[k]);
}
// M and m of the rounding bounds, and |Im q| of the joint where it is largest, as a lower bound: 1 - 1 / e^|Im q|.
struct Growth {
    Block all, side, imaginary;
};
STEP Growth growth_of(const CBlock (&z)[6]) {
    Block side[2] = {1.0, 1.0}, most = 1.0;
    for (int k = 0; k < 6; ++k) {
        const Block length = square(z[k]), each = max(length, 1.0 / (length + TINY));
        side[k / 3] *= each, most = max(most, each);
    }
    return {sqrt(side[0] * side[1]), sqrt(max(side[0], side[1])), 1.0 - 1.0 / sqrt(most)};
}
STEP Growth growth_of(const Block (&)[6]) { return {1.0, 1.0, 0.0}; }

}  // namespace urdf_ik::URDF_IK_LEVEL
