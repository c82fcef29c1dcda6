// Singular values of small matrices by one-sided Jacobi rotations (Hestenes 1958), accurate for small ones too.
#pragma once

#include "arithmetic/trig.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A = U diag(s) V^T, s falling. left[k]: column k of U; right[k]: column k of V.
template <int R, int C> struct Svd {
    double left[C][R], right[C][C], s[C];
};

template <int R> STEP double inner_product(const double (&a)[R], const double (&b)[R]) {
    double sum = 0.0;
    for (int i = 0; i < R; ++i) sum += a[i] * b[i];
    return sum;
}
template <int R> STEP double length_of(const double (&a)[R]) { return sqrt(inner_product(a, a)); }

// The rotation of two columns that makes them orthogonal.
template <int R> STEP void rotate(double (&a)[R], double (&b)[R], double c, double s) {
    for (int i = 0; i < R; ++i) {
        const double p = a[i], q = b[i];
        a[i] = c * p - s * q, b[i] = s * p + c * q;
    }
}

// columns: of A.
template <int R, int C> PART void svd(const double (&columns)[C][R], Svd<R, C>& out) {
    for (int k = 0; k < C; ++k) {
        for (int i = 0; i < R; ++i) out.left[k][i] = columns[k][i];
        for (int i = 0; i < C; ++i) out.right[k][i] = i == k ? 1.0 : 0.0;
    }
    bool moved = true;
    for (int sweep = 0; sweep < 30 && moved; ++sweep) {
        moved = false;
        for (int p = 0; p < C; ++p) {
            for (int q = p + 1; q < C; ++q) {
                const double a = inner_product(out.left[p], out.left[p]), b = inner_product(out.left[q], out.left[q]);
                const double g = inner_product(out.left[p], out.left[q]);
                if (!(abs(g) > 1e-15 * sqrt(a * b)) || abs(g) < TINY) continue;
                moved = true;
                const double zeta = (b - a) / (2.0 * g);
                const double t = copysign(1.0, zeta) / (abs(zeta) + sqrt(1.0 + zeta * zeta)), c = 1.0 / sqrt(1.0 + t * t);
                rotate(out.left[p], out.left[q], c, c * t), rotate(out.right[p], out.right[q], c, c * t);
            }
        }
    }
    for (int k = 0; k < C; ++k) out.s[k] = length_of(out.left[k]);
    for (int k = 1; k < C; ++k) {
        for (int i = k; i > 0 && out.s[i] > out.s[i - 1]; --i) {
            exchange(out.s[i], out.s[i - 1]);
            for (int j = 0; j < R; ++j) exchange(out.left[i][j], out.left[i - 1][j]);
            for (int j = 0; j < C; ++j) exchange(out.right[i][j], out.right[i - 1][j]);
        }
    }
    // Columns of vanishing length have no direction left: each becomes the unit vector that is most across the others.
    for (int k = 0; k < C; ++k) {
        double best[R] = {};
        double most = -1.0;
        for (int from = -1; from < R; ++from) {
            double v[R];
            for (int i = 0; i < R; ++i) v[i] = from < 0 ? out.left[k][i] : double(i == from);
            const double before = length_of(v);
            if (from < 0 && before < TINY) continue;
            for (int round = 0; round < 2; ++round) {
                for (int l = 0; l < k; ++l) {
                    const double along = inner_product(out.left[l], v);
                    for (int i = 0; i < R; ++i) v[i] = v[i] - along * out.left[l][i];
                }
            }
            const double after = length_of(v), share = after / before;
            if (share > most) {
                most = share;
                for (int i = 0; i < R; ++i) best[i] = (1.0 / after) * v[i];
            }
            if (from < 0 && share > 0.5) break;
        }
        for (int i = 0; i < R; ++i) out.left[k][i] = best[i];
    }
}

}  // namespace urdf_ik::URDF_IK_LEVEL
