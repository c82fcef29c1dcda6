// Steps of Newton's method: least squares by modified Gram-Schmidt on the columns of [J e], which is backward stable
// for the solution (Bjorck, BIT 7, 1967). Damped steps use [J; damping I] in place of J (Levenberg, Marquardt).
#pragma once

#include "arithmetic/vectors.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

template <int N, class V> struct Solved {
    V x[N];
    V least;  // a lower bound on the smallest singular value of J, too small by a factor of at most sqrt(N)
};

// The triangular factor of J and the inverses of its diagonal: J = Q R, R[k][k] = 1 / w[k].
template <int N, class V> struct Triangle {
    V R[N][N], w[N];
};

// R's inverse, upper triangular. Returns one over its Frobenius norm.
template <int N, class V> STEP V invert(const Triangle<N, V>& f, V (&inverse)[N][N]) {
    V square = 0.0;
#pragma GCC unroll 7
    for (int k = N - 1; k >= 0; --k) {
        inverse[k][k] = f.w[k];
        square += f.w[k] * f.w[k];
#pragma GCC unroll 7
        for (int l = k + 1; l < N; ++l) {
            V sum = 0.0;
#pragma GCC unroll 7
            for (int m = k + 1; m <= l; ++m) sum += f.R[k][m] * inverse[m][l];
            inverse[k][l] = -(f.w[k] * sum);
            square += inverse[k][l] * inverse[k][l];
        }
    }
    return inverse_sqrt(square);
}
template <int N, class V> STEP V least_stretch(const Triangle<N, V>& f) {
    V inverse[N][N];
    return invert(f, inverse);
}

// Solve J x = e in the least-squares sense; damped: minimise |J x - e|^2 + |damping x|^2. J is overwritten.
template <bool damped, int N, int rows, class V>
STEP Solved<N, V> least_squares(Rows<rows, V> (&J)[N], Rows<rows, V> e, const V& damping) {
    Triangle<N, V> f;
    V y[N], low[N][N], e_low[N];  // low: the rows below J; entry i of column k is zero for i > k
    if constexpr (damped) {
        for (int k = 0; k < N; ++k) {
            for (int i = 0; i < N; ++i) low[k][i] = i == k ? damping : V(0.0);
            e_low[k] = 0.0;
        }
    }
#pragma GCC unroll 7
    for (int k = 0; k < N; ++k) {
        V square = dot(J[k], J[k]) + TINY;
        if constexpr (damped) {
            for (int i = 0; i <= k; ++i) square += low[k][i] * low[k][i];
        }
        f.w[k] = inverse_sqrt(square);
        J[k] = times(J[k], f.w[k]);
        if constexpr (damped) {
            for (int i = 0; i <= k; ++i) low[k][i] = low[k][i] * f.w[k];
        }
#pragma GCC unroll 7
        for (int l = k + 1; l < N; ++l) {
            V r = dot(J[k], J[l]);
            if constexpr (damped) {
                for (int i = 0; i <= k; ++i) r += low[k][i] * low[l][i];
                for (int i = 0; i <= k; ++i) low[l][i] -= r * low[k][i];
            }
            J[l] = less(J[l], r, J[k]);
            f.R[k][l] = r;
        }
        y[k] = dot(J[k], e);
        if constexpr (damped) {
            for (int i = 0; i < k; ++i) y[k] += low[k][i] * e_low[i];
            for (int i = 0; i <= k; ++i) e_low[i] -= y[k] * low[k][i];
        }
        e = less(e, y[k], J[k]);
    }
    Solved<N, V> out;
#pragma GCC unroll 7
    for (int k = N - 1; k >= 0; --k) {
        V rest = y[k];
#pragma GCC unroll 7
        for (int l = k + 1; l < N; ++l) rest -= f.R[k][l] * out.x[l];
        out.x[k] = rest * f.w[k];
    }
    out.least = least_stretch(f);
    return out;
}

// The least-squares inverse X (N, rows) of J: J x = e is solved by x = X e. J becomes Q. Returns the lower bound of
// Solved::least. X = R^-1 Q^T: Q^T Q differs from the identity by rounding times the condition of J (Bjorck), and so does X
// from the inverse, relative to its size.
template <int N, int rows, class V> STEP V inverse(Rows<rows, V> (&J)[N], V (&X)[N * rows]) {
    Triangle<N, V> f;
#pragma GCC unroll 7
    for (int k = 0; k < N; ++k) {
        f.w[k] = inverse_sqrt(dot(J[k], J[k]) + TINY);
        J[k] = times(J[k], f.w[k]);
#pragma GCC unroll 7
        for (int l = k + 1; l < N; ++l) f.R[k][l] = dot(J[k], J[l]), J[l] = less(J[l], f.R[k][l], J[k]);
    }
    V inverse[N][N];
    const V least = invert(f, inverse);
#pragma GCC unroll 7
    for (int k = 0; k < N; ++k) {
#pragma GCC unroll 7
        for (int c = 0; c < rows; ++c) {
            V sum = inverse[k][k] * J[k][c];
#pragma GCC unroll 7
            for (int l = k + 1; l < N; ++l) sum += inverse[k][l] * J[l][c];
            X[rows * k + c] = sum;
        }
    }
    return least;
}

// The smallest singular value of J and its right singular vector.
template <int N> struct Weakest {
    double value, direction[N];
};

// Inverse iteration on the triangular factor of J.
template <int N, int rows> PART Weakest<N> weakest(Rows<rows, double> (&J)[N]) {
    double R[N][N], x[N], y[N];
    for (int k = 0; k < N; ++k) {
        const double length = sqrt(dot(J[k], J[k]));
        R[k][k] = max(length, 1e-30);
        J[k] = times(J[k], 1.0 / R[k][k]);
        for (int l = k + 1; l < N; ++l) R[k][l] = dot(J[k], J[l]), J[l] = less(J[l], R[k][l], J[k]);
    }
    Weakest<N> out;
    for (double& each : x) each = 1.0;
    for (int round = 0; round < 4; ++round) {
        double square = 0.0;
        for (int i = 0; i < N; ++i) {
            double rest = x[i];
            for (int j = 0; j < i; ++j) rest -= R[j][i] * y[j];
            y[i] = rest / R[i][i];
        }
        for (int i = N - 1; i >= 0; --i) {
            double rest = y[i];
            for (int j = i + 1; j < N; ++j) rest -= R[i][j] * x[j];
            x[i] = rest / R[i][i];
            square += x[i] * x[i];
        }
        const double length = sqrt(square);
        for (double& each : x) each /= length;
        out.value = 1.0 / sqrt(length);
    }
    for (int i = 0; i < N; ++i) out.direction[i] = x[i];
    return out;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
