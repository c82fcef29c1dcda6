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

// The norms of T_ttt's coefficients, of the first 6 - r outputs and of the others. The coefficient of a monomial counts with one
// over the root of the binomial coefficient.
struct ThirdOrder {
    double y, t;
};
// r: one or two variables. A monomial of degree d has the exponent of the second one as its place.
PART ThirdOrder third_order(const Local& at, int r) {
    TwistProduct P[4][4] = {};  // of the product so far: degree, monomial
    const int n = 6 - r;
    const auto count = [r](int d) { return r == 1 ? 1 : d + 1; };
    for (int k = 0; k < 6; ++k) {
        const TwistProduct one = matrix_of(at.twist[k]), two = times(one, one, 0.5), three = times(two, one, 1.0 / 3.0);
        Number L[4][4] = {};  // the powers of the linear form, by its coefficients
        L[0][0] = 1.0;
        const auto raised = [&](int d, const auto& f) {  // f(place in degree d, place in degree d + 1, coefficient)
            for (int i = 0; i < count(d); ++i) {
                for (int v = 0; v < r; ++v) f(i, i + v, at.J.right[n + v][k]);
            }
        };
        for (int d = 0; d < 3; ++d) raised(d, [&](int from, int to, const Number& c) { L[d + 1][to] += c * L[d][from]; });
        // From the highest degree down: P_d gains P_(d-1) zeta L + P_(d-2) zeta^2 L^2 / 2 + zeta^3 L^3 / 6.
        raised(2, [&](int from, int to, const Number& c) { add_scaled(P[3][to], c, times(P[2][from], one, 1.0)); });
        for (int i = 0; i < count(1); ++i) {
            const TwistProduct each = times(P[1][i], two, 1.0);
            for (int j = 0; j < count(2); ++j) add_scaled(P[3][i + j], L[2][j], each);
        }
        for (int i = 0; i < count(3); ++i) add_scaled(P[3][i], L[3][i], three);
        raised(1, [&](int from, int to, const Number& c) { add_scaled(P[2][to], c, times(P[1][from], one, 1.0)); });
        for (int i = 0; i < count(2); ++i) add_scaled(P[2][i], L[2][i], two);
        for (int i = 0; i < count(1); ++i) add_scaled(P[1][i], L[1][i], one);
    }
    double sum[2] = {0.0, 0.0};
    for (int i = 0; i < count(3); ++i) {
        const Six<Number> V = vector_of_product(P[3][i]);
        for (int o = 0; o < 6; ++o) sum[o >= n] += square(along(at.J.left[o], V)) / (i % 3 ? 3.0 : 1.0);
    }
    const double off = ROUNDING_OF_FORMS * at.spread * at.spread * at.spread;
    return {sqrt(sum[0]) + off, sqrt(sum[1]) + off};
}

}  // namespace urdf_ik::URDF_IK_LEVEL
