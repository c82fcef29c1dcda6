// Two angles u and v, linked by two equations: cos u and sin u are both affine in (cos v, sin v). Since cos^2 u + sin^2 u = 1, v is
// a root of a trigonometric polynomial of degree two: there are up to four pairs of angles. This problem occurs in arms with three
// parallel axes, and in arms with a spherical triple in the middle.
#pragma once

#include "numbers/quartic.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// constant + cosine cos v + sine sin v
template <class V> struct Affine {
    V constant, cosine, sine;
};
STEP Affine<double> scaled(const Affine<double>& a, double by) { return {a.constant * by, a.cosine * by, a.sine * by}; }

// Angles v at which cos u = c(v) and sin u = s(v) have a common u. error_c, error_s: of the coefficients of c and s; the quartic's
// own are rounded to less than nine units of the sums of squares.
STEP Quartic linked_roots(const Affine<double>& c, const Affine<double>& s, double error_c = 0.0, double error_s = 0.0) {
    const double cosines = c.cosine * c.cosine + s.cosine * s.cosine, sines = c.sine * c.sine + s.sine * s.sine;
    const double of_c = abs(c.constant) + abs(c.cosine) + abs(c.sine) + error_c,
                 of_s = abs(s.constant) + abs(s.cosine) + abs(s.sine) + error_s;
    const double error = 2.0 * (of_c * error_c + of_s * error_s) + 1e-15 * (1.0 + of_c * of_c + of_s * of_s);
    return trigonometric_roots(
        {c.constant * c.constant + s.constant * s.constant - 1.0 + 0.5 * (cosines + sines),
         2.0 * (c.constant * c.cosine + s.constant * s.cosine), 2.0 * (c.constant * c.sine + s.constant * s.sine),
         0.5 * (cosines - sines), c.cosine * c.sine + s.cosine * s.sine},
        error);
}

// Roots closer than this to an extreme of cos u [rad] are refined; farther away the quartic is accurate enough.
inline constexpr double BESIDE_EXTREME = 1e-4;
// A quadratic's leading coefficient or a derivative per rad below this (dimensionless) is too small to divide by.
inline constexpr double FLAT = 1e-9;

// An extreme of cos u: the angle v there, cos u and sin^2 u there, and how cos u changes with 1 - cos(v - extreme).
struct Extreme {
    Turn<double> at;
    double cosine, square, slope;
};

// With x the distance from the extreme and w = 1 - cos x, sin u = b + g sin x + k w and cos u = cosine + slope w, so that
// sin^2 u = square - 2 cosine slope w - slope^2 w^2 without cancellation. Two steps of Newton's method on the difference.
STEP double sharpened(double x, double b, double g, double k, const Extreme& e) {
    for (int round = 0; round < 2; ++round) {
        const double half = exact_turn(0.5 * x).s, w = 2.0 * half * half;
        const auto [c, s] = exact_turn(x);
        const double bend = b + g * s + k * w, value = bend * bend - e.square + (2.0 * e.cosine + e.slope * w) * e.slope * w;
        const double change = 2.0 * bend * (g * c + k * s) + 2.0 * (e.cosine + e.slope * w) * e.slope * s;
        if (abs(change) > FLAT * abs(x)) x -= value / change;
    }
    return x;
}

STEP Turn<double> beside(const Turn<double>& at, double x) {
    const auto [c, s] = exact_turn(x);
    return {at.c * c - at.s * s, at.s * c + at.c * s};
}

// Refine roots at which cos u is almost +-1 and near its extreme. There two roots of the quartic nearly meet and are accurate to
// half of their digits. They are computed again from the quadratic equation to second order in x.
PART void sharpen_roots(const Extreme& e, const Affine<double>& sine, Quartic& roots) {
    const auto away = [&](int i) { return e.at.c * roots.root[i].s - e.at.s * roots.root[i].c; };
    int first = -1, second = -1;
    for (int i = 0; i < roots.count; ++i) {
        if (e.at.c * roots.root[i].c + e.at.s * roots.root[i].s > 0.0 && abs(away(i)) < BESIDE_EXTREME)
            (first < 0 ? first : second) = i;
    }
    if (first < 0) return;
    const double k = -(sine.cosine * e.at.c + sine.sine * e.at.s), b = sine.constant - k,
                 g = sine.sine * e.at.c - sine.cosine * e.at.s;
    const double square = g * g + b * k + e.cosine * e.slope, half = b * g;
    if (abs(square) < FLAT) return;
    const double spread = sqrt(max(half * half - square * (b * b - e.square), 0.0)) / abs(square);
    const double low = sharpened(-half / square - spread, b, g, k, e), high = sharpened(-half / square + spread, b, g, k, e);
    const auto replace = [&](int i, const Turn<double>& by) {
        const double c = by.c - roots.root[i].c, s = by.s - roots.root[i].s;
        roots.radius[i] += sqrt(c * c + s * s), roots.root[i] = by;
    };
    double x = away(first);
    if (second >= 0) {
        const bool ordered = x <= away(second);
        x = ordered ? low : high;
        replace(second, beside(e.at, ordered ? high : low));
    } else {
        x = abs(low - x) < abs(high - x) ? low : high;
    }
    replace(first, beside(e.at, x));
}

}  // namespace urdf_ik::URDF_IK_LEVEL
