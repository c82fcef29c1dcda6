// All complex roots of a polynomial that reads the same from both ends, as the harmonics of a real function have it.
#pragma once

#include "trig.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

struct Complex {
    double re, im;
};

// A polynomial's value below this share of the sum of its terms' sizes is rounding.
inline constexpr double LOST = 4e-16;

// The logarithmic derivative p'(z) / p(z) of a self-inversive polynomial, a root a lane; outside the unit circle it is
// n / z - conj(p'(u) / p(u)) / z^2 at the mirror image u = 1 / conj(z), so that no power overflows. Roots whose value is
// lost in rounding come to rest.
template <int N>
STEP void slope_over_value(const Complex (&c)[N + 1], const double (&x)[N], const double (&y)[N], double (&moves)[N], double (&a)[N],
                           double (&b)[N]) {
    double zx[N], zy[N], size[N], p[N], q[N], u[N], v[N], bound[N];
    for (int k = 0; k < N; ++k) {
        const double square = x[k] * x[k] + y[k] * y[k], f = square <= 1.0 ? 1.0 : 1.0 / square;
        zx[k] = x[k] * f, zy[k] = y[k] * f, size[k] = sqrt(square) * f;
        p[k] = c[N].re, q[k] = c[N].im, u[k] = 0.0, v[k] = 0.0, bound[k] = abs(c[N].re) + abs(c[N].im);
    }
    for (int j = N - 1; j >= 0; --j) {
        const double magnitude = abs(c[j].re) + abs(c[j].im);
        for (int k = 0; k < N; ++k) {
            const double un = u[k] * zx[k] - v[k] * zy[k] + p[k], vn = u[k] * zy[k] + v[k] * zx[k] + q[k];
            const double pn = p[k] * zx[k] - q[k] * zy[k] + c[j].re, qn = p[k] * zy[k] + q[k] * zx[k] + c[j].im;
            u[k] = un, v[k] = vn, p[k] = pn, q[k] = qn, bound[k] = bound[k] * size[k] + magnitude;
        }
    }
    for (int k = 0; k < N; ++k) {
        const double square = p[k] * p[k] + q[k] * q[k], lost = LOST * bound[k], w = 1.0 / (square + TINY);
        moves[k] = square <= lost * lost ? 0.0 : moves[k];
        const double re = (u[k] * p[k] + v[k] * q[k]) * w, im = (v[k] * p[k] - u[k] * q[k]) * w;
        const double s = x[k] * x[k] + y[k] * y[k], ix = x[k] / s, iy = -y[k] / s, i2 = ix * ix - iy * iy, j2 = 2.0 * ix * iy;
        a[k] = s > 1.0 ? N * ix - (i2 * re + j2 * im) : re;
        b[k] = s > 1.0 ? N * iy - (j2 * re - i2 * im) : im;
    }
}

// c: from the constant up, c[N - k] the conjugate of c[k]. Aberth's iteration on all roots side by side (Aberth 1973).
template <int N> PART void self_inversive_roots(const Complex (&c)[N + 1], Complex (&z)[N]) {
    double x[N], y[N], moves[N], a[N], b[N];
    for (int k = 0; k < N; ++k) {
        const double angle = 2.0 * PI * k / N + 0.3, radius = 1.0 + 0.2 * ((k % 3) - 1);
        x[k] = radius * __builtin_cos(angle), y[k] = radius * __builtin_sin(angle), moves[k] = 1.0;
    }
    for (int round = 0; round < 60; ++round) {
        slope_over_value<N>(c, x, y, moves, a, b);
        for (int j = 0; j < N; ++j) {
            for (int k = 0; k < N; ++k) {
                const double dx = x[k] - x[j], dy = y[k] - y[j], w = 1.0 / (dx * dx + dy * dy + TINY);
                a[k] -= dx * w, b[k] += dy * w;
            }
        }
        double moving = 0.0;
        for (int k = 0; k < N; ++k) {
            const double w = moves[k] / (a[k] * a[k] + b[k] * b[k] + TINY), dx = a[k] * w, dy = -b[k] * w;
            const double square = x[k] * x[k] + y[k] * y[k];
            moves[k] = dx * dx + dy * dy < 1e-30 * max(square, 1e-6) ? 0.0 : moves[k];
            x[k] -= dx, y[k] -= dy;
            moving += moves[k];
        }
        if (moving == 0.0) break;
    }
    for (int k = 0; k < N; ++k) z[k] = {x[k], y[k]};
}

}  // namespace urdf_ik::URDF_IK_LEVEL
