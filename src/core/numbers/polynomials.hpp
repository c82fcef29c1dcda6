// All complex roots of a self-inversive polynomial: coefficient N - k is the conjugate of coefficient k, as for the harmonics of a
// real function.
#pragma once

#include "numbers/complex.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

using Complex = Complexes<double>;

// Horner's rule in complex numbers loses at most this share of the sum of its terms' sizes a step: four units of roundoff. A value
// below it is rounding.
inline constexpr double HORNER = 4.8e-16;

// A root has converged when it moves by less than this, relative to its size (squared). Convergence is cubic. Only multiple roots
// converge linearly, and they are accurate to half of their digits anyway.
inline constexpr double AT_REST = 1e-22;

// The logarithmic derivative p'(z) / p(z) of a self-inversive polynomial, one root per lane. Outside the unit circle it is
// n / z - conj(p'(u) / p(u)) / z^2 at the mirror image u = 1 / conj(z), so that no power overflows. A root at which the value of p
// is rounding stops moving.
template <int N, class V>
STEP void slope_over_value(const Complex (&c)[N + 1], const V& x, const V& y, MaskOf<V>& moves, V& a, V& b) {
    const V square = x * x + y * y, inverse = 1.0 / square;
    const auto outside = square > V(1.0);
    const V f = select(outside, inverse, 1.0), zx = x * f, zy = y * f, size = sqrt(square) * f;
    V p = c[N].re, q = c[N].im, u = 0.0, v = 0.0, bound = abs(c[N].re) + abs(c[N].im);
#pragma GCC unroll 4
    for (int j = N - 1; j >= 0; --j) {
        const V un = u * zx - v * zy + p, vn = u * zy + v * zx + q;
        const V pn = p * zx - q * zy + c[j].re, qn = p * zy + q * zx + c[j].im;
        u = un, v = vn, p = pn, q = qn, bound = bound * size + (abs(c[j].re) + abs(c[j].im));
    }
    const V value = p * p + q * q, lost = HORNER * bound, w = 1.0 / (value + TINY);
    moves = moves & (value > lost * lost);
    const V re = (u * p + v * q) * w, im = (v * p - u * q) * w;
    const V ix = x * inverse, iy = -(y * inverse), i2 = ix * ix - iy * iy, j2 = 2.0 * ix * iy;
    a = select(outside, double(N) * ix - (i2 * re + j2 * im), re);
    b = select(outside, double(N) * iy - (j2 * re - i2 * im), im);
}

// c: from the constant up, c[N - k] the conjugate of c[k]. Aberth's iteration on all roots side by side (Aberth 1973).
template <int N> PART void self_inversive_roots(const Complex (&c)[N + 1], Complex (&z)[N]) {
    using V = Row<N>;
    alignas(64) double xs[N], ys[N];
    for (int k = 0; k < N; ++k) xs[k] = 2.0 * PI * (k - N / 2) / N + 0.3, ys[k] = 1.0 + 0.2 * ((k % 3) - 1);
    const Turn<V> start = cos_sin(load<V>(xs));
    V x = load<V>(ys) * start.c, y = load<V>(ys) * start.s, a, b;
    auto moves = x < V(__builtin_inf());
    for (int round = 0; round < 60; ++round) {
        slope_over_value<N>(c, x, y, moves, a, b);
        store(x, xs), store(y, ys);
#pragma GCC unroll 1
        for (int j = 0; j < N; ++j) {
            // The repulsion between the roots steers convergence. It need not be exact.
            const V dx = x - xs[j], dy = y - ys[j], w = rough_inverse(dx * dx + dy * dy + TINY);
            a -= dx * w, b += dy * w;
        }
        const V w = 1.0 / (a * a + b * b + TINY), dx = a * w, dy = -(b * w);
        x = select(moves, x - dx, x), y = select(moves, y - dy, y);
        moves = moves & (dx * dx + dy * dy >= AT_REST * max(x * x + y * y, V(1e-6)));
        if (!any(moves)) break;
    }
    store(x, xs), store(y, ys);
    for (int k = 0; k < N; ++k) z[k] = {xs[k], ys[k]};
}

// Radii of discs about numbers z, of which every group of k that meet holds k roots of any polynomial whose coefficients are within
// `error` of these: N |p(z_i)| / |c_N prod (z_i - z_j)| (Smith 1970, from Gershgorin's theorem). A product of
// distances loses less than SLACK_OF_SUMS.
template <int N> PART void root_discs(const Complex (&c)[N + 1], const Complex (&z)[N], double error, double (&radius)[N]) {
    for (int i = 0; i < N; ++i) {
        const double size = sqrt(z[i].re * z[i].re + z[i].im * z[i].im);
        double re = c[N].re, im = c[N].im, terms = abs(re) + abs(im), powers = 1.0, apart = 1.0;
        const double leading = sqrt(re * re + im * im) - error;
        for (int j = N - 1; j >= 0; --j) {
            const double x = re * z[i].re - im * z[i].im + c[j].re;
            im = re * z[i].im + im * z[i].re + c[j].im, re = x;
            terms = terms * size + abs(c[j].re) + abs(c[j].im), powers = powers * size + 1.0;
        }
        for (int j = 0; j < N; ++j) {
            const double x = z[i].re - z[j].re, y = z[i].im - z[j].im;
            if (j != i) apart *= sqrt(x * x + y * y);
        }
        const double value = sqrt(re * re + im * im) + N * HORNER * terms + error * powers;
        radius[i] = leading > 0.0 && apart > 0.0 ? SLACK_OF_SUMS * N * value / (leading * apart) : __builtin_inf();
    }
}

}  // namespace urdf_ik::URDF_IK_LEVEL
