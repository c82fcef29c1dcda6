// Terms of third order of the loop equation at one complex joint vector, in the directions of the small singular values: the
// coefficients of the product of exponentials.
#pragma once

#include "certificate/local.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A product of matrices of twists, without its last row, which is zero.
struct TwistProduct {
    Number R[3][3], p[3];
};
STEP TwistProduct matrix_of(const Six<Number>& zeta) {
    const Number &x = zeta[3], &y = zeta[4], &z = zeta[5], none = 0.0;
    return {{{none, -z, y}, {z, none, -x}, {-y, x, none}}, {zeta[0], zeta[1], zeta[2]}};
}
PART TwistProduct times(const TwistProduct& a, const TwistProduct& b, double f) {
    TwistProduct out;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) out.R[i][j] = f * (a.R[i][0] * b.R[0][j] + a.R[i][1] * b.R[1][j] + a.R[i][2] * b.R[2][j]);
        out.p[i] = f * (a.R[i][0] * b.p[0] + a.R[i][1] * b.p[1] + a.R[i][2] * b.p[2]);
    }
    return out;
}
PART void add_scaled(TwistProduct& to, const Number& f, const TwistProduct& a) {
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) to.R[i][j] += f * a.R[i][j];
        to.p[i] += f * a.p[i];
    }
}

// V of a product: position, and vector of the skew part.
STEP Six<Number> vector_of_product(const TwistProduct& c) {
    return {{c.p[0], c.p[1], c.p[2], 0.5 * (c.R[2][1] - c.R[1][2]), 0.5 * (c.R[0][2] - c.R[2][0]), 0.5 * (c.R[1][0] - c.R[0][1])}};
}

// a* b.
STEP Number along(const Number (&a)[6], const Six<Number>& b) {
    Number sum = 0.0;
    for (int i = 0; i < 6; ++i) sum += conj(a[i]) * b[i];
    return sum;
}

// Monomials of degree d in r variables have places 0 to COUNT[r - 1][d] - 1, by their exponents a of the first and b of the second.
inline constexpr int COUNT[3][4] = {{1, 1, 1, 1}, {1, 2, 3, 4}, {1, 3, 6, 10}};
STEP int place_of(int r, int d, int a, int b) { return r == 1 ? 0 : r == 2 ? d - a : (d - a) * (d - a + 1) / 2 + (d - a - b); }

// The norms of T_ttt's coefficients, of the first 6 - r outputs and of the others. The coefficient of a monomial counts with one
// over the root of the multinomial coefficient.
struct ThirdOrder {
    double y, t;
};
PART ThirdOrder third_order(const Local& at, int r) {
    TwistProduct P[4][10] = {};  // of the product so far: degree, monomial
    const int n = 6 - r;
    for (int k = 0; k < 6; ++k) {
        const TwistProduct one = matrix_of(at.twist[k]), two = times(one, one, 0.5), three = times(two, one, 1.0 / 3.0);
        // The powers of the linear form, by its coefficients.
        Number L[4][10] = {};
        L[0][0] = 1.0;
        const auto raised = [&](int d, const auto& f) {  // f(place in degree d, place in degree d + 1, variable)
            for (int a = 0; a <= d; ++a) {
                for (int b = 0; b <= (r == 1 ? 0 : d - a); ++b) {
                    if ((r == 1 && a != d) || (r == 2 && a + b != d)) continue;
                    for (int v = 0; v < r; ++v) f(place_of(r, d, a, b), place_of(r, d + 1, a + (v == 0), b + (v == 1)), v);
                }
            }
        };
        for (int d = 0; d < 3; ++d) {
            raised(d, [&](int from, int to, int v) { L[d + 1][to] += at.J.right[n + v][k] * L[d][from]; });
        }
        // From the highest degree down: P_d gains P_(d-1) zeta L + P_(d-2) zeta^2 L^2 / 2 + zeta^3 L^3 / 6.
        const auto by_form = [&](int d, const auto& of) {
            raised(d, [&](int from, int to, int v) { of(from, to, at.J.right[n + v][k]); });
        };
        by_form(2, [&](int from, int to, const Number& c) { add_scaled(P[3][to], c, times(P[2][from], one, 1.0)); });
        for (int i = 0; i < COUNT[r - 1][1]; ++i) {
            // P_1's monomial i times L^2.
            const TwistProduct each = times(P[1][i], two, 1.0);
            for (int a = 0; a <= 2; ++a) {
                for (int b = 0; b <= (r == 1 ? 0 : 2 - a); ++b) {
                    if ((r == 1 && a != 2) || (r == 2 && a + b != 2)) continue;
                    add_scaled(P[3][place_of(r, 3, a + (i == 0), b + (i == 1))], L[2][place_of(r, 2, a, b)], each);
                }
            }
        }
        for (int i = 0; i < COUNT[r - 1][3]; ++i) add_scaled(P[3][i], L[3][i], three);
        by_form(1, [&](int from, int to, const Number& c) { add_scaled(P[2][to], c, times(P[1][from], one, 1.0)); });
        for (int i = 0; i < COUNT[r - 1][2]; ++i) add_scaled(P[2][i], L[2][i], two);
        for (int i = 0; i < COUNT[r - 1][1]; ++i) add_scaled(P[1][i], L[1][i], one);
    }
    double sum[2] = {0.0, 0.0};
    for (int a = 0; a <= 3; ++a) {
        for (int b = 0; b <= (r == 1 ? 0 : 3 - a); ++b) {
            if ((r == 1 && a != 3) || (r == 2 && a + b != 3)) continue;
            constexpr double factorial[4] = {1.0, 1.0, 2.0, 6.0};
            const double many = 6.0 / (factorial[a] * factorial[b] * factorial[3 - a - b]);
            const TwistProduct& c = P[3][place_of(r, 3, a, b)];
            const Six<Number> V = vector_of_product(c);
            for (int o = 0; o < 6; ++o) sum[o >= n] += square(along(at.J.left[o], V)) / many;
        }
    }
    const double off = ROUNDING_OF_FORMS * at.spread * at.spread * at.spread;
    return {sqrt(sum[0]) + off, sqrt(sum[1]) + off};
}

}  // namespace urdf_ik::URDF_IK_LEVEL
