// The equations of one pose, their determinant, and how many real solutions its zeros on the circle leave room for.
#pragma once

#include "certify/circle.hpp"
#include "families/general/collecting.hpp"
#include "families/general/hidden_joint.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The zeros of a determinant are counted if what separates its matrices from those of the arm as written is at most this.
inline constexpr double LARGEST_INEXACT = 1e-6;

// The motion that the six joints must make together, in the scaled frame of the axes.
STEP Frame<double> loop_motion(const EliminationArm& arm, const Goal<double>& goal, bool reversed) {
    const Frame<double> to = beyond(goal, arm.home_inverse);
    const Frame<double> motion = {to.R, arm.scale * (to.p - vec<double>(arm.centre))};
    return reversed ? inverse(motion) : motion;
}

// A bound on the length of this motion, and of those that it is computed from.
STEP double length_of_motion(const EliminationArm& arm, const Goal<double>& goal) {
    const auto length = [](const double (&t)[3]) { return sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]); };
    return arm.scale * (sqrt(dot(goal.p, goal.p)) + length(arm.home_inverse.t) + length(arm.centre));
}

// The hidden joint of a variant, from the base on.
STEP int hidden_joint(const EliminationVariant& variant) {
    const int hidden = (variant.first + 5) % 6;
    return variant.reversed ? 5 - hidden : hidden;
}
// Its value at q, as (cos, sin) of its angle, or of t where it slides by tan(t / 2).
STEP Turn<double> hidden_at(const EliminationArm& arm, const EliminationVariant& variant, const double (&q)[6]) {
    const int j = hidden_joint(variant);
    if (!arm.written.slides[j]) return cos_sin(q[j]);
    const double d = arm.scale * q[j], w = 1.0 / (1.0 + d * d);
    return {(1.0 - d * d) * w, 2.0 * d * w};
}

// The equations of a pose, and their determinant: 24 times its Fourier coefficients, a bound on the error of each, and the noise.
struct Eliminant {
    Frame<double> G;
    Equations A;
    Complex coefficients[2 * DEGREE + 1];
    double error, noise;
};
PART void eliminate(const EliminationArm& arm, const EliminationVariant& variant, const Goal<double>& goal, Eliminant& out) {
    double D[SAMPLES];
    const double reach = length_of_motion(arm, goal);
    out.G = loop_motion(arm, goal, variant.reversed);
    equations(variant, out.G, out.A);
    determinants<Block>(out.A, D, variant.inexact[0] + reach * (variant.inexact[1] + reach * variant.inexact[2]), out.error);
    out.noise = harmonics(D, out.coefficients);
}

// The same as a polynomial on the circle; nothing is known where its error is infinite.
STEP OnCircle<double> on_circle(const Eliminant& of) {
    OnCircle<double> p;
    for (int k = 0; k <= DEGREE; ++k) p.re[k] = of.coefficients[DEGREE + k].re, p.im[k] = of.coefficients[DEGREE + k].im;
    // Higher harmonics are zero, so what rounding leaves of them is within the bound.
    double largest = 0.0;
    for (int k = 0; k <= DEGREE; ++k) largest = max(largest, sqrt(p.re[k] * p.re[k] + p.im[k] * p.im[k]));
    p.error = of.noise * largest <= of.error ? of.error : __builtin_inf();
    return p;
}

// Bounds the number of real solutions by that of the zeros that the determinant of the arm as written has on the circle. A zero is
// at least as multiple as its matrix loses ranks. A matrix that loses one rank belongs to one solution at most; one that loses two
// to two at most: null vectors of solutions lie on a surface that is cut out by quadrics and contains no line.
// Returns whether that many real roots are certified.
template <class S>
PART bool count_zeros(const EliminationArm& arm, const EliminationVariant& variant, const OnCircle<S>& p, SearchState& search) {
    if (search.counted() || !search.certifies || !(p.error < __builtin_inf())) return search.counted();
    double known[Account::most];
    for (int i = 0; i < search.account.reals; ++i) {
        const Turn<double> t = hidden_at(arm, variant, search.account.real[i].q);
        known[i] = atan2(t.s, t.c);
    }
    const int bound = zeros_on_circle(p, known, search.account.reals);
    if (bound >= 0 && (search.zeros < 0 || bound < search.zeros)) search.zeros = bound;
    return search.counted();
}

// Whether a variant's determinant is known well enough to be worth counting its zeros.
STEP bool counts(const EliminationVariant& variant) { return variant.inexact[0] < LARGEST_INEXACT; }

}  // namespace urdf_ik::URDF_IK_LEVEL
