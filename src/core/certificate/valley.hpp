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

// The highest order that is followed, and the number of terms up to it, for a curve (r = 1) and for a surface (r = 2).
template <int r> inline constexpr int ORDERS = r == 1 ? 8 : 6;
template <int r> inline constexpr int TERMS = r == 1 ? 9 : 28;
inline constexpr int HIGHEST = ORDERS<1>;
// The place of t_1^(n - b) t_2^b among the terms.
template <int r> constexpr int term_of(int n, int b) { return r == 1 ? n : n * (n + 1) / 2 + b; }
// A joint vector that keeps the pose to this without being a solution may stand for one.
inline constexpr double NEARLY_KEPT = 1e-10;
// Rounding of a coefficient, relative to the same coefficient of the factors' norms: six products of sums of up to HIGHEST
// products, or 16 on a surface, 11 u or 19 u each, of factors from as many products.
template <int r> inline constexpr double ROUNDING_OF_SERIES = (r == 1 ? 200.0 : 400.0) * UNIT;

// Norms of a polynomial without terms of order 0 and 1: bent[n] bounds the terms of order n by bent[n] |t|^n. With several t it is
// the root of the sum of squares, each over its multinomial coefficient: as the norm of a symmetric tensor, it bounds derivatives
// along a unit vector by n bent[n] |t|^(n - 1), too.
template <int r> struct Bent {
    static constexpr int N = ORDERS<r>;
    double bent[N + 1] = {};

    // Bounds for |t| <= R: on |y(t)|, |y'(t)| and |y''(t)|.
    STEP double height(double R) const {
        double sum = 0.0;
        for (int n = N; n > 1; --n) sum = (sum + bent[n]) * R;
        return sum * R;
    }
    STEP double steepness(double R) const {
        double sum = 0.0;
        for (int n = N; n > 1; --n) sum = (sum + n * bent[n]) * R;
        return sum;
    }
    STEP double bending(double R) const {
        double sum = 0.0;
        for (int n = N; n > 2; --n) sum = (sum + n * (n - 1) * bent[n]) * R;
        return sum + 2.0 * bent[2];
    }
};
// y(t) = sum of a_n t^n: their real parts.
struct Curve : Bent<1> {
    double bend[HIGHEST + 1][5] = {};

    // The curve at t.
    STEP void at(double t, double (&y)[5]) const {
        for (int k = 0; k < 5; ++k) {
            y[k] = 0.0;
            for (int n = HIGHEST; n > 1; --n) y[k] = (y[k] + bend[n][k]) * t;
            y[k] *= t;
        }
    }
    STEP void slope_at(double t, double (&slope)[5]) const {
        for (int k = 0; k < 5; ++k) {
            slope[k] = 0.0;
            for (int n = HIGHEST; n > 1; --n) slope[k] = (slope[k] + n * bend[n][k]) * t;
        }
    }
};
// The same of t_1 and t_2.
struct Surface : Bent<2> {
    double bend[TERMS<2>][4] = {};

    // The surface at t, and its derivatives by t_1 and t_2.
    PART void at(const double (&t)[2], double (&y)[4], double (&slope)[2][4]) const {
        for (int k = 0; k < 4; ++k) y[k] = slope[0][k] = slope[1][k] = 0.0;
        double power[2][N + 1] = {{1.0}, {1.0}};
        for (int n = 1; n <= N; ++n) power[0][n] = power[0][n - 1] * t[0], power[1][n] = power[1][n - 1] * t[1];
        for (int n = 2; n <= N; ++n) {
            for (int b = 0; b <= n; ++b) {
                const int a = n - b;
                const double by_1 = a ? a * power[0][a - 1] * power[1][b] : 0.0, by_2 = b ? b * power[0][a] * power[1][b - 1] : 0.0;
                const double (&c)[4] = bend[term_of<2>(n, b)];
                for (int k = 0; k < 4; ++k) {
                    y[k] += c[k] * power[0][a] * power[1][b], slope[0][k] += c[k] * by_1, slope[1][k] += c[k] * by_2;
                }
            }
        }
    }
};
// What is left of the last r outputs on the curve or the surface.
template <int r> struct Left : std::conditional_t<r == 1, Curve, Surface> {
    static constexpr int N = ORDERS<r>;
    // By order, from 1 on: bounds on f's coefficients, of the first outputs and of the last ones, and what the last ones are at
    // least. value: the last ones' real parts, from 0 on.
    double y[N + 1], t[N + 1], least[N + 1], value[r][TERMS<r>];
    double norm[N + 1];  // of d's coefficients, times the twists' norms

    // A bound on f's terms beyond the order N, for |t| <= R: the exponential of the norms' series less its first terms. Both sums
    // are rounded.
    STEP double beyond(double R) const {
        double e[N + 1] = {1.0}, known = 1.0, power = 1.0, exponent = 0.0;
        for (int n = 1; n <= N; ++n) {
            e[n] = 0.0;
            for (int j = 1; j <= n; ++j) e[n] += j * norm[j] * e[n - j];
            e[n] /= n, power *= R;
            known += e[n] * power, exponent += norm[n] * power;
        }
        const double all = exponential(exponent);
        return max(all - known, 0.0) + 60.0 * UNIT * all;
    }
};
struct Valley : Left<1> {
    // The last output at t, and its derivative.
    STEP double output(double t, double& slope) const {
        double sum = 0.0;
        slope = 0.0;
        for (int n = HIGHEST; n >= 0; --n) slope = slope * t + sum, sum = sum * t + value[0][n];
        return sum;
    }
};

STEP double real_part(double a) { return a; }
STEP double real_part(const Number& a) { return a.re; }

// Both factors' places, in f, of each product of two terms, but 1, that is t_1^(n - b) t_2^b; and the first one's order.
template <int r, class F> STEP void products_of(int n, int b, const F& f) {
    for (int i = 1; i < n; ++i) {
        for (int c = r == 1 || i < n - b ? 0 : i - (n - b); c <= (r == 1 ? 0 : b < i ? b : i); ++c) {
            f(term_of<r>(i, c), term_of<r>(n - i, b - c), i);
        }
    }
}

// bent: whether the curve bends; without, it is the line y = 0.
template <int r, class V> PART void follow(const Local& at, bool bent, Left<r>& out) {
    constexpr int N = ORDERS<r>, all_terms = TERMS<r>, strong = 6 - r;
    TwistProduct<V> power[6][N + 1], factor[6][all_terms], P[6][all_terms];  // zeta^m / m!; terms of each exponential; of products
    V raised[6][N + 1][all_terms] = {};  // terms of d_k^m
    V left[6][6];
    for (int o = 0; o < 6; ++o) {
        for (int i = 0; i < 6; ++i) left[o][i] = part<V>(at.J.left[o][i]);
    }
    double spread = 0.0;
    for (int v = 0; v < r; ++v) {
        double sum = 0.0;
        for (int k = 0; k < 6; ++k) sum += at.length[k] * sqrt(square(at.J.right[strong + v][k]));
        spread = r == 1 ? sum : spread + sum * sum;
        out.value[v][0] = at.g[strong + v].re;
    }
    out.norm[1] = SLACK_OF_SUMS * (r == 1 ? spread : sqrt(spread));
    for (int k = 0; k < 6; ++k) {
        Six<V> twist;
        for (int i = 0; i < 6; ++i) twist[i] = part<V>(at.twist[k][i]);
        power[k][1] = matrix_of(twist);
        for (int m = 2; m <= N; ++m) power[k][m] = times(power[k][m - 1], power[k][1], 1.0 / m);
        for (int v = 0; v < r; ++v) raised[k][1][term_of<r>(1, v)] = part<V>(at.J.right[strong + v][k]);
    }
    double e[N + 1] = {1.0};
    for (int n = 1; n <= N; ++n) {
        double size = 0.0, across = 0.0, last = 0.0, many = 1.0;  // many: the multinomial coefficient
        for (int b = 0; b <= (r == 1 ? 0 : n); ++b) {
            const int term = term_of<r>(n, b);
            for (int k = 0; k < 6; ++k) {
                TwistProduct<V>&E = factor[k][term], &all = P[k][term];
                E = {};
                products_of<r>(n, b, [&](int one, int other, int order) {
                    const V d = raised[k][1][one];
                    for (int m = 2; m <= n - order + 1; ++m) raised[k][m][term] += d * raised[k][m - 1][other];
                });
                for (int m = 1; m <= n; ++m) add_scaled(E, raised[k][m][term], power[k][m]);
                all = E;
                if (!k) continue;
                add_scaled(all, V(1.0), P[k - 1][term]);
                products_of<r>(n, b, [&](int one, int other, int) { add_product(all, P[k - 1][one], factor[k][other]); });
            }
            Six<V> F = vector_of_product(P[5][term]);
            if (bent && n > 1) {
                V a[strong];
                for (int y = 0; y < strong; ++y) {
                    a[y] = (-1.0 / at.J.s[y]) * along(left[y], F), size += square(a[y]) / many;
                    out.bend[term][y] = real_part(a[y]);
                }
                TwistProduct<V> sum = {};
                for (int k = 0; k < 6; ++k) {
                    V d = 0.0;
                    for (int y = 0; y < strong; ++y) d += part<V>(at.J.right[y][k]) * a[y];
                    raised[k][1][term] = d;
                    add_scaled(factor[k][term], d, power[k][1]), add_scaled(sum, d, power[k][1]);
                    add_scaled(P[k][term], V(1.0), sum);
                }
                F = vector_of_product(P[5][term]);
            }
            for (int y = 0; y < strong; ++y) across += square(along(left[y], F)) / many;
            for (int v = 0; v < r; ++v) {
                const V left_over = along(left[strong + v], F);
                out.value[v][term] = real_part(left_over), last += square(left_over) / many;
            }
            many *= (n - b) / (b + 1.0);
        }
        out.bent[n] = SLACK_OF_SUMS * sqrt(size);
        if (n > 1) out.norm[n] = SLACK_OF_SUMS * at.spread * out.bent[n];
        e[n] = 0.0;
        for (int j = 1; j <= n; ++j) e[n] += j * out.norm[j] * e[n - j];
        e[n] /= n;
        const double off = e[n] * (ROUNDING_OF_SERIES<r> + n * at.blur);
        out.y[n] = sqrt(across) + off, out.t[n] = sqrt(last) + off, out.least[n] = out.t[n] - 2.0 * off;
    }
}
PART void follow_valley(const Local& at, bool bent, Valley& out) {
    static_cast<Curve&>(out) = {};
    if (is_real(at.q)) follow<1, double>(at, bent, out);
    else follow<1, Number>(at, bent, out);
}

}  // namespace urdf_ik::URDF_IK_LEVEL
