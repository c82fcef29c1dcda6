// Kinematics of arms whose joints drive several axes each, for Newton's method.
#pragma once

#include "families/mimics/coupled_arm.hpp"
#include "propose/candidates.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

template <class V> struct CoupledPosture {
    Frame<V> axis[MOST_AXES], tip;
};
template <int N, class V> STEP CoupledPosture<V> place(const Coupled<N>& arm, const V (&x)[N]) {
    CoupledPosture<V> at;
    Frame<V> next = constant_frame<V>(arm.step[0]);
    for (int k = 0; k < arm.axes; ++k) {
        V value = 0.0;
        for (int j = 0; j < N; ++j) value += arm.gain[k][j] * x[j];
        at.axis[k] = next;
        const Frame<V> moved = arm.slides[k] ? Frame<V>{next.R, next.p + value * next.R.z} : turned(next, cos_sin_of_any(value));
        next = beyond(moved, arm.step[k + 1]);
    }
    at.tip = next;
    return at;
}

// A joint's column is the sum of those of the axes that it drives.
template <int N, class V> STEP void jacobian_at(const Coupled<N>& arm, const CoupledPosture<V>& at, Six<V> (&J)[N]) {
    const double inverse_size = 1.0 / arm.size;
    for (auto& column : J) column = {{V(0.0), V(0.0), V(0.0), V(0.0), V(0.0), V(0.0)}};
    for (int k = 0; k < arm.axes; ++k) {
        const double share = arm.slides[k] ? inverse_size : 1.0;
        const Six<V> each = jacobian_column(at.axis[k], arm.slides[k], at.tip.p, inverse_size);
        for (int j = 0; j < N; ++j) J[j] = less(J[j], V(-share * arm.gain[k][j]), each);
    }
}

// The model for Newton's method.
template <int N> struct Driven {
    static constexpr int joints = N, rows = 6;
    const Coupled<N>& arm;
    const Tolerances& tolerances;
};
template <int N> STEP Driven<N> driven(const Coupled<N>& arm) { return {arm, arm.tolerances}; }

template <int N, class V> STEP Error<V> error_at(const Driven<N>& model, const Goal<V>& goal, const V (&x)[N]) {
    return pose_error(goal, place(model.arm, x).tip, 1.0 / model.arm.size);
}
template <int N, class V>
STEP Error<V> error_and_jacobian(const Driven<N>& model, const Goal<V>& goal, const V (&x)[N], Six<V> (&J)[N]) {
    const CoupledPosture<V> at = place(model.arm, x);
    jacobian_at(model.arm, at, J);
    return pose_error(goal, at.tip, 1.0 / model.arm.size);
}
// The image of x that is nearest to zero.
template <int N> STEP double centred(const Coupled<N>& arm, int k, double x) {
    const double period = arm.period[k];
    return period > 0.0 ? x - period * __builtin_floor(x / period + 0.5) : x;
}
template <int N> STEP double advanced(const Driven<N>& model, int k, double x, double step) {
    return centred(model.arm, k, x + step);
}
template <int N> STEP double gap(const Driven<N>& model, int k, double a, double b) { return centred(model.arm, k, a - b); }

// Polishes x in place and keeps the result if it is verified and new. searched: x may be far from any solution, so it
// has to converge to rounding.
template <int N> STEP void polish_and_keep(const Coupled<N>& arm, const Goal<double>& goal, double (&x)[N], bool searched,
                                           const Columns<N>& columns) {
    polish_and_keep(driven(arm), goal, x, searched ? Origin::searched : Origin::doubtful,
                    searched ? CONVERGED : arm.tolerances.reach, columns);
}

// Scaled joints to joint values, in the order of the columns.
template <int N> STEP void finish(const Coupled<N>& arm, const Columns<N>& columns) {
    sort(columns);
    for (int b = 0; b < columns.many; ++b) {
        for (int j = 0; j < N; ++j) columns.row(b)[j] *= arm.unit[j];
    }
}

}  // namespace urdf_ik::URDF_IK_LEVEL
