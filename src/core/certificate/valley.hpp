// The loop along a valley: a curve through a joint vector, along the direction of J's smallest singular value, on which f vanishes
// in the other five directions up to the order HIGHEST.
//
// In the directions of the singular values, the curve is t in the last one and y(t) = a_2 t^2 + a_3 t^3 + ... in the others. The
// coefficients of Y = exp(zeta_1 d_1(t)) ... exp(zeta_6 d_6(t)) follow from those of its factors order by order: a_n adds J a_n to
// f's coefficient of order n and nothing to the lower ones, so a_n is chosen so that the first five outputs vanish. What remains is
// a power series in t for the last output: its zeros are the solutions near the valley.
#pragma once

#include "certificate/series.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The highest order that is followed.
inline constexpr int HIGHEST = 8;
// A joint vector that keeps the pose to this without being a solution may stand for one.
inline constexpr double NEARLY_KEPT = 1e-10;
// Rounding of a coefficient, relative to the same coefficient of the factors' norms: six products of sums of up to HIGHEST
// products, 11 u each, of factors from as many products.
inline constexpr double ROUNDING_OF_SERIES = 200.0 * UNIT;

// y(t) = sum of a_n t^n, and the last output on it.
struct Valley {
    double bent[HIGHEST + 1] = {}, bend[HIGHEST + 1][5] = {};  // norms of a_n, and their real parts
    // By order, from 1 on: bounds on f's coefficients, of the first outputs and of the last one, and what the last one is at least.
    // value: the last one's real parts, from 0 on.
    double y[HIGHEST + 1], t[HIGHEST + 1], least[HIGHEST + 1], value[HIGHEST + 1];
    double norm[HIGHEST + 1];  // of d's coefficients, times the twists' norms

    // A bound on |y(t)| for |t| <= R.
    STEP double height(double R) const {
        double sum = 0.0;
        for (int n = HIGHEST; n > 1; --n) sum = (sum + bent[n]) * R;
        return sum * R;
    }
    // The curve at t.
    STEP void at(double t, double (&y)[5]) const {
        for (int k = 0; k < 5; ++k) {
            y[k] = 0.0;
            for (int n = HIGHEST; n > 1; --n) y[k] = (y[k] + bend[n][k]) * t;
            y[k] *= t;
        }
    }
    // A bound on f's terms beyond the order HIGHEST, for |t| <= R: the exponential of the norms' series less its first terms. Both
    // sums are rounded.
    STEP double beyond(double R) const {
        double e[HIGHEST + 1] = {1.0}, known = 1.0, power = 1.0, exponent = 0.0;
        for (int n = 1; n <= HIGHEST; ++n) {
            e[n] = 0.0;
            for (int j = 1; j <= n; ++j) e[n] += j * norm[j] * e[n - j];
            e[n] /= n, power *= R;
            known += e[n] * power, exponent += norm[n] * power;
        }
        const double all = exponential(exponent);
        return max(all - known, 0.0) + 60.0 * UNIT * all;
    }
};

STEP double real_part(double a) { return a; }
STEP double real_part(const Number& a) { return a.re; }

// bent: whether the curve bends; without, it is the line y = 0.
template <class V> PART void follow(const Local& at, bool bent, Valley& out) {
    constexpr int N = HIGHEST;
    TwistProduct<V> power[6][N + 1], factor[6][N + 1], P[6][N + 1];  // zeta^m / m!; terms of each exponential; of products
    V raised[6][N + 1][N + 1] = {};  // terms of d_k^m
    V left[6][6];
    for (int o = 0; o < 6; ++o) {
        for (int i = 0; i < 6; ++i) left[o][i] = part<V>(at.J.left[o][i]);
    }
    double spread = 0.0;
    for (int k = 0; k < 6; ++k) spread += at.length[k] * sqrt(square(at.J.right[5][k]));
    out.value[0] = at.g[5].re, out.norm[1] = SLACK_OF_SUMS * spread;
    for (int k = 0; k < 6; ++k) {
        Six<V> twist;
        for (int i = 0; i < 6; ++i) twist[i] = part<V>(at.twist[k][i]);
        power[k][1] = matrix_of(twist);
        for (int m = 2; m <= N; ++m) power[k][m] = times(power[k][m - 1], power[k][1], 1.0 / m);
        raised[k][1][1] = part<V>(at.J.right[5][k]);
    }
    double e[N + 1] = {1.0};
    for (int n = 1; n <= N; ++n) {
        double size = 0.0, across = 0.0;
        for (int k = 0; k < 6; ++k) {
            TwistProduct<V>&E = factor[k][n], &all = P[k][n];
            E = {};
            for (int i = 1; i < n; ++i) {
                for (int m = 2; m <= n - i + 1; ++m) raised[k][m][n] += raised[k][1][i] * raised[k][m - 1][n - i];
            }
            for (int m = 1; m <= n; ++m) add_scaled(E, raised[k][m][n], power[k][m]);
            all = E;
            if (!k) continue;
            add_scaled(all, V(1.0), P[k - 1][n]);
            for (int i = 1; i < n; ++i) add_product(all, P[k - 1][i], factor[k][n - i]);
        }
        Six<V> F = vector_of_product(P[5][n]);
        if (bent && n > 1) {
            V a[5];
            for (int y = 0; y < 5; ++y) {
                a[y] = (-1.0 / at.J.s[y]) * along(left[y], F), size += square(a[y]);
                out.bend[n][y] = real_part(a[y]);
            }
            TwistProduct<V> sum = {};
            for (int k = 0; k < 6; ++k) {
                V d = 0.0;
                for (int y = 0; y < 5; ++y) d += part<V>(at.J.right[y][k]) * a[y];
                raised[k][1][n] = d;
                add_scaled(factor[k][n], d, power[k][1]), add_scaled(sum, d, power[k][1]);
                add_scaled(P[k][n], V(1.0), sum);
            }
            F = vector_of_product(P[5][n]);
        }
        for (int y = 0; y < 5; ++y) across += square(along(left[y], F));
        const V left_over = along(left[5], F);
        out.value[n] = real_part(left_over);
        out.bent[n] = SLACK_OF_SUMS * sqrt(size);
        if (n > 1) out.norm[n] = SLACK_OF_SUMS * at.spread * out.bent[n];
        e[n] = 0.0;
        for (int j = 1; j <= n; ++j) e[n] += j * out.norm[j] * e[n - j];
        e[n] /= n;
        const double off = e[n] * (ROUNDING_OF_SERIES + n * at.blur);
        out.y[n] = sqrt(across) + off, out.t[n] = sqrt(square(left_over)) + off, out.least[n] = out.t[n] - 2.0 * off;
    }
}
PART void follow_valley(const Local& at, bool bent, Valley& out) {
    if (is_real(at.q)) follow<double>(at, bent, out);
    else follow<Number>(at, bent, out);
}

}  // namespace urdf_ik::URDF_IK_LEVEL
