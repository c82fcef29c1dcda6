// Singular values of small complex matrices by one-sided Jacobi rotations (Hestenes 1958), accurate for small ones too.
#pragma once

#include "arithmetic/complex.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

using Number = Complexes<double>;

STEP double conj(double a) { return a; }
STEP double square(double a) { return a * a; }

// A = U diag(s) V*, s falling, of real or complex numbers. left[k]: column k of U; right[k]: column k of V.
template <int R, int C, class N = Number> struct Svd {
    N left[C][R], right[C][C];
    double s[C];
};

// a* b.
template <int R, class N> STEP N inner_product(const N (&a)[R], const N (&b)[R]) {
    N sum = 0.0;
    for (int i = 0; i < R; ++i) sum += conj(a[i]) * b[i];
    return sum;
}
template <int R, class N> STEP double square_of(const N (&a)[R]) {
    double sum = 0.0;
    for (const N& each : a) sum += square(each);
    return sum;
}

// The rotation of two columns that makes them orthogonal.
template <int R, class N> STEP void rotate(N (&a)[R], N (&b)[R], double c, double s, const N& phase) {
    for (int i = 0; i < R; ++i) {
        const N p = a[i], q = phase * b[i];
        a[i] = c * p - s * q, b[i] = s * p + c * q;
    }
}

// columns: of A.
template <int R, int C, class N> PART void svd(const N (&columns)[C][R], Svd<R, C, N>& out) {
    for (int k = 0; k < C; ++k) {
        for (int i = 0; i < R; ++i) out.left[k][i] = columns[k][i];
        for (int i = 0; i < C; ++i) out.right[k][i] = i == k ? 1.0 : 0.0;
    }
    bool moved = true;
    for (int sweep = 0; sweep < 30 && moved; ++sweep) {
        moved = false;
        for (int p = 0; p < C; ++p) {
            for (int q = p + 1; q < C; ++q) {
                const double a = square_of(out.left[p]), b = square_of(out.left[q]);
                const N g = inner_product(out.left[p], out.left[q]);
                const double size = sqrt(square(g));
                if (!(size > 1e-15 * sqrt(a * b)) || size < TINY) continue;
                moved = true;
                const double zeta = (b - a) / (2.0 * size);
                const double t = copysign(1.0, zeta) / (abs(zeta) + sqrt(1.0 + zeta * zeta)), c = 1.0 / sqrt(1.0 + t * t);
                const N phase = (1.0 / size) * conj(g);
                rotate(out.left[p], out.left[q], c, c * t, phase), rotate(out.right[p], out.right[q], c, c * t, phase);
            }
        }
    }
    for (int k = 0; k < C; ++k) out.s[k] = sqrt(square_of(out.left[k]));
    for (int k = 1; k < C; ++k) {
        for (int i = k; i > 0 && out.s[i] > out.s[i - 1]; --i) {
            const double s = out.s[i];
            out.s[i] = out.s[i - 1], out.s[i - 1] = s;
            for (int j = 0; j < R; ++j) {
                const N x = out.left[i][j];
                out.left[i][j] = out.left[i - 1][j], out.left[i - 1][j] = x;
            }
            for (int j = 0; j < C; ++j) {
                const N x = out.right[i][j];
                out.right[i][j] = out.right[i - 1][j], out.right[i - 1][j] = x;
            }
        }
    }
    // Columns of vanishing length have no direction left: each becomes the unit vector that is most across the others.
    for (int k = 0; k < C; ++k) {
        N best[R] = {};
        double most = -1.0;
        for (int from = -1; from < R; ++from) {
            N v[R];
            for (int i = 0; i < R; ++i) v[i] = from < 0 ? out.left[k][i] : N(i == from ? 1.0 : 0.0);
            const double before = sqrt(square_of(v));
            if (from < 0 && before < TINY) continue;
            for (int round = 0; round < 2; ++round) {
                for (int l = 0; l < k; ++l) {
                    const N along = inner_product(out.left[l], v);
                    for (int i = 0; i < R; ++i) v[i] = v[i] - along * out.left[l][i];
                }
            }
            const double after = sqrt(square_of(v)), share = after / before;
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
