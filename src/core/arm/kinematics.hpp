// Forward kinematics and Jacobian of the arm as written. Source: Lynch and Park, Modern Robotics, chapters 4 and 5.
#pragma once

#include "arm/arm.hpp"
#include "numbers/vectors.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The frames at one joint vector: each joint's frame before the joint moves, and the tip.
template <int N, class V> struct Posture {
    Frame<V> joint[N], tip;
};

template <class V> STEP Frame<V> constant_frame(const Motion& m) {
    return {{{m.R[0][0], m.R[1][0], m.R[2][0]}, {m.R[0][1], m.R[1][1], m.R[2][1]}, {m.R[0][2], m.R[1][2], m.R[2][2]}},
            {m.t[0], m.t[1], m.t[2]}};
}

STEP Motion motion_of(const Frame<double>& at) {
    const auto& [x, y, z] = at.R;
    return {{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}}, {at.p.x, at.p.y, at.p.z}};
}
STEP Frame<double> inverse(const Frame<double>& at) {
    const auto& [x, y, z] = at.R;
    return {{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}}, {-dot(x, at.p), -dot(y, at.p), -dot(z, at.p)}};
}
// The inverse of a motion, and the motion b in the frame that a moves: of doubles, or of numbers of twice the digits.
template <class M> PART M inverse_of(const M& m) {
    M out;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) out.R[i][j] = m.R[j][i];
        out.t[i] = -(m.R[0][i] * m.t[0] + m.R[1][i] * m.t[1] + m.R[2][i] * m.t[2]);
    }
    return out;
}
template <class M> PART M composed(const M& a, const M& b) {
    M out;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) out.R[i][j] = a.R[i][0] * b.R[0][j] + a.R[i][1] * b.R[1][j] + a.R[i][2] * b.R[2][j];
        out.t[i] = a.t[i] + a.R[i][0] * b.t[0] + a.R[i][1] * b.t[1] + a.R[i][2] * b.t[2];
    }
    return out;
}

// The frame after a constant step, which is given in the frame itself.
template <class V> STEP Frame<V> beyond(const Frame<V>& at, const Motion& step) {
    return {at.R * step.R, at.p + combine(at.R, step.t[0], step.t[1], step.t[2])};
}

// The frame after its joint has moved by q.
template <class V> STEP Frame<V> moved(const Frame<V>& at, bool slides, const V& q) {
    if (slides) return {at.R, at.p + q * at.R.z};
    return turned(at, cos_sin(q));
}

// q: angles in [-1.1 pi, 1.1 pi], lengths in m.
template <int N, class V> PART Posture<N, V> place(const Written<N>& arm, const V (&q)[N]) {
    Posture<N, V> at;
    at.joint[0] = constant_frame<V>(arm.step[0]);
#pragma GCC unroll 1
    for (int k = 0; k + 1 < N; ++k) at.joint[k + 1] = beyond(moved(at.joint[k], arm.slides[k], q[k]), arm.step[k + 1]);
    at.tip = beyond(moved(at.joint[N - 1], arm.slides[N - 1], q[N - 1]), arm.step[N]);
    return at;
}

// The tip of an arm whose joints all turn. joint: the frames of the joints, before their turns.
template <int N, class V> STEP Frame<V> joints_and_tip(const Written<N>& arm, const Turn<V> (&turn)[N], Frame<V> (&joint)[N]) {
    Frame<V> at = constant_frame<V>(arm.step[0]);
    for (int k = 0; k < N; ++k) joint[k] = at, at = beyond(turned(at, turn[k]), arm.step[k + 1]);
    return at;
}

// A joint's column of the geometric Jacobian at the tip, lengths as shares of the size (1 / inverse_size). For a slide it is the
// joint's direction.
template <class V> STEP Six<V> jacobian_column(const Frame<V>& joint, bool slides, const Vec<V>& tip, double inverse_size) {
    const Vec<V>& z = joint.R.z;
    if (slides) return {{z.x, z.y, z.z, V(0.0), V(0.0), V(0.0)}};
    const Vec<V> arm = V(inverse_size) * (tip - joint.p), v = cross(z, arm);
    return {{v.x, v.y, v.z, z.x, z.y, z.z}};
}

// The second derivative by joints i <= j of a motion's position and of its rotation's skew part, with the joints' twists (v, w):
// (w_i x v_j, w_i x w_j / 2).
template <class V> STEP Six<V> second_derivative(const Six<V>& i, const Six<V>& j) {
    const Vec<V> w = {i[3], i[4], i[5]}, a = cross(w, Vec<V>{j[0], j[1], j[2]}), b = cross(w, Vec<V>{j[3], j[4], j[5]});
    return {{a.x, a.y, a.z, 0.5 * b.x, 0.5 * b.y, 0.5 * b.z}};
}

}  // namespace urdf_ik::URDF_IK_LEVEL
