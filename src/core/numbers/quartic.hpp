// Real roots of a trigonometric polynomial of degree two: the quartic of some families.
#pragma once

#include "numbers/polynomials.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A second harmonic below this share of the largest coefficient is zero to rounding.
inline constexpr double NO_HARMONIC = 1e-14;

// Real roots as (cos, sin), in the order of their angles.
struct Quartic {
    Turn<double> root[4];
    int count;
    // A root lies within its radius of where it is given. alone: a bit for each root that is proven to be real, with no other one
    // within its radius; of the others, as many as are given lie within their radii, real or not. whole: all roots that are not
    // given are proven not to be real.
    double radius[4];
    unsigned alone;
    bool whole;
};

// constant + cosine cos t + sine sin t + cosine2 cos 2t + sine2 sin 2t
struct TrigonometricPolynomial {
    double constant, cosine, sine, cosine2, sine2;
};

// error: of the coefficients. The roots of a real function are mirrored in the unit circle: with z, 1 / conj(z) is one too. A root
// z within r <= 1 / 2 of a point u of the circle has its image within |z - u| / |z| <= r / (1 - r) <= 2 r of u. Where no other
// root's disc comes within 2 r of u, the image is the root itself, which is real then.
template <int N> STEP void collect_real(const Complex (&c)[N + 1], double error, Quartic& out) {
    Complex z[N];
    double radius[N];
    self_inversive_roots<N>(c, z);
    root_discs<N>(c, z, error, radius);
    out.whole = true;
    double open = 0.0;
    for (int i = 0; i < N; ++i) {
        const double size = sqrt(z[i].re * z[i].re + z[i].im * z[i].im), off = abs(size - 1.0);
        if (!(size > 0.0 && abs(logarithm(size)) < NEAR)) {
            out.whole = out.whole && radius[i] < 0.5 * off;
            for (int j = 0; j < N; ++j) {
                const double x = z[i].re - z[j].re, y = z[i].im - z[j].im;
                if (j != i) out.whole = out.whole && radius[i] + radius[j] < sqrt(x * x + y * y);
            }
            continue;
        }
        const Turn<double> root = {z[i].re / size, z[i].im / size};
        const double at = angle(root), wide = 2.0 * (radius[i] + off);
        bool alone = wide <= 1.0;
        for (int j = 0; j < N; ++j) {
            const double x = root.c - z[j].re, y = root.s - z[j].im;
            if (j != i) alone = alone && wide + radius[j] < sqrt(x * x + y * y);
        }
        if (!alone) open += 2.0 * (radius[i] + off);
        int place = out.count++;
        for (; place > 0 && angle(out.root[place - 1]) > at; --place) {
            out.root[place] = out.root[place - 1], out.radius[place] = out.radius[place - 1];
            out.alone = (out.alone & ~(1u << place)) | (out.alone >> (place - 1) & 1u) << place;
        }
        out.root[place] = root, out.radius[place] = radius[i] + off;
        out.alone = (out.alone & ~(1u << place)) | unsigned(alone) << place;
    }
    // Discs that meet: together they are no wider than this.
    for (int i = 0; i < out.count; ++i) {
        if (!(out.alone >> i & 1u)) out.radius[i] = open;
    }
}

// Roots of constant + cosine cos t + sine sin t; error: of each coefficient.
STEP Quartic first_harmonic_roots(double constant, double cosine, double sine, double error) {
    Quartic out = {};
    const Complex first = {0.5 * cosine, 0.5 * sine};
    if (first.re != 0.0 || first.im != 0.0) collect_real<2>({first, {constant, 0.0}, {first.re, -first.im}}, error, out);
    return out;
}

// With z = exp(it) the polynomial is a self-inversive quartic, whose roots on the unit circle are the real ones. All four are found
// together, without case distinctions. A pair just off the circle is returned as two roots; the caller verifies them. error: of
// each coefficient.
PART Quartic trigonometric_roots(const TrigonometricPolynomial& p, double error = 0.0) {
    Quartic out = {};
    const Complex first = {0.5 * p.cosine, 0.5 * p.sine}, second = {0.5 * p.cosine2, 0.5 * p.sine2};
    const double largest = max(abs(p.constant), max(max(abs(first.re), abs(first.im)), max(abs(second.re), abs(second.im))));
    if (!(largest > 0.0)) return out;
    if (max(abs(second.re), abs(second.im)) < NO_HARMONIC * largest) {
        // z divides out once at each end. The discs are those of another polynomial.
        out = first_harmonic_roots(p.constant, p.cosine, p.sine, error);
        out.whole = false;
    } else {
        collect_real<4>(
            {{second.re, second.im}, {first.re, first.im}, {p.constant, 0.0}, {first.re, -first.im}, {second.re, -second.im}},
            error, out);
    }
    return out;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
