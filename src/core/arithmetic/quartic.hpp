// Real roots of a trigonometric polynomial of degree two: the quartic of some families.
#pragma once

#include "arithmetic/polynomials.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Real roots as (cos, sin), in the order of their angles.
struct Quartic {
    Turn<double> root[4];
    int count;

    // Squared distance on the unit circle from a root to the nearest other one; 4 if it is the only root.
    STEP double gap(int i) const {
        double least = 4.0;
        for (int k = 0; k < count; ++k) {
            const double c = root[k].c - root[i].c, s = root[k].s - root[i].s;
            if (k != i) least = min(least, c * c + s * s);
        }
        return least;
    }
};

// constant + cosine cos t + sine sin t + cosine2 cos 2t + sine2 sin 2t
struct TrigonometricPolynomial {
    double constant, cosine, sine, cosine2, sine2;
};

// A complex pair this close to the unit circle (in its logarithm) may be a double real root that rounding has split.
inline constexpr double NEAR_UNIT_CIRCLE = 1e-3;
// A second harmonic below this share of the largest coefficient is zero to rounding.
inline constexpr double NO_HARMONIC = 1e-14;

template <int N> STEP void collect_real(const Complex (&c)[N + 1], Quartic& out) {
    Complex z[N];
    self_inversive_roots<N>(c, z);
    for (const Complex& each : z) {
        const double size = sqrt(each.re * each.re + each.im * each.im);
        if (!(size > 0.0 && abs(logarithm(size)) < NEAR_UNIT_CIRCLE)) continue;
        const Turn<double> root = {each.re / size, each.im / size};
        const double at = angle(root);
        int place = out.count++;
        for (; place > 0 && angle(out.root[place - 1]) > at; --place) out.root[place] = out.root[place - 1];
        out.root[place] = root;
    }
}

// With z = exp(it) the polynomial is a self-inversive quartic, whose roots on the unit circle are the real ones. All four are found
// together, without case distinctions. A pair just off the circle is returned as two roots; the caller verifies them.
PART Quartic trigonometric_roots(const TrigonometricPolynomial& p) {
    Quartic out = {};
    const Complex first = {0.5 * p.cosine, 0.5 * p.sine}, second = {0.5 * p.cosine2, 0.5 * p.sine2};
    const double largest = max(abs(p.constant), max(max(abs(first.re), abs(first.im)), max(abs(second.re), abs(second.im))));
    if (!(largest > 0.0)) return out;
    if (max(abs(second.re), abs(second.im)) < NO_HARMONIC * largest) {
        // z divides out once at each end.
        collect_real<2>({{first.re, first.im}, {p.constant, 0.0}, {first.re, -first.im}}, out);
    } else {
        collect_real<4>(
            {{second.re, second.im}, {first.re, first.im}, {p.constant, 0.0}, {first.re, -first.im}, {second.re, -second.im}}, out);
    }
    return out;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
