// Singular values of small matrices by one-sided Jacobi rotations (Hestenes 1958), accurate for small ones too.
#pragma once

#include "numbers/trig.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A V = U diag(s), s falling. image[k]: column k of A V; right[k]: column k of V.
template <int R, int C> struct Svd {
    double image[C][R], right[C][C], s[C];
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
        for (int i = 0; i < R; ++i) out.image[k][i] = columns[k][i];
        for (int i = 0; i < C; ++i) out.right[k][i] = i == k ? 1.0 : 0.0;
    }
    bool moved = true;
    for (int sweep = 0; sweep < 30 && moved; ++sweep) {
        moved = false;
        for (int p = 0; p < C; ++p) {
            for (int q = p + 1; q < C; ++q) {
                const double a = inner_product(out.image[p], out.image[p]), b = inner_product(out.image[q], out.image[q]);
                const double g = inner_product(out.image[p], out.image[q]);
                if (!(abs(g) > 1e-15 * sqrt(a * b)) || abs(g) < TINY) continue;
                moved = true;
                const double zeta = (b - a) / (2.0 * g);
                const double t = copysign(1.0, zeta) / (abs(zeta) + sqrt(1.0 + zeta * zeta)), c = 1.0 / sqrt(1.0 + t * t);
                rotate(out.image[p], out.image[q], c, c * t), rotate(out.right[p], out.right[q], c, c * t);
            }
        }
    }
    for (int k = 0; k < C; ++k) out.s[k] = length_of(out.image[k]);
    for (int k = 1; k < C; ++k) {
        for (int i = k; i > 0 && out.s[i] > out.s[i - 1]; --i) {
            exchange(out.s[i], out.s[i - 1]);
            for (int j = 0; j < R; ++j) exchange(out.image[i][j], out.image[i - 1][j]);
            for (int j = 0; j < C; ++j) exchange(out.right[i][j], out.right[i - 1][j]);
        }
    }
}

}  // namespace urdf_ik::URDF_IK_LEVEL
