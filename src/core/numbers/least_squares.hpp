// Steps of Newton's method: least squares by modified Gram-Schmidt on the columns of [J e], which is backward stable
// for the solution (Bjorck, BIT 7, 1967). Damped steps use [J; damping I] in place of J (Levenberg, Marquardt).
#pragma once

#include "numbers/vectors.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

template <int N, class V> struct Solved {
    V x[N];
    V least;  // a lower bound on the smallest singular value of J, too small by a factor of at most sqrt(N)
};

// The triangular factor of J and the inverses of its diagonal: J = Q R, R[k][k] = 1 / w[k].
template <int N, class V> struct Triangle {
    V R[N][N], w[N];
};

// One over the Frobenius norm of R's inverse, which is upper triangular.
template <int N, class V> STEP V least_stretch(const Triangle<N, V>& f) {
    V inverse[N][N], square = 0.0;
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

// The least-squares inverse X (N, rows) of J: J x = e is solved by x = X e. Returns one over its Frobenius norm, which is no
// greater than the smallest singular value of J, and too small by a factor of at most sqrt(N). J becomes Q, whose columns are
// orthogonal and keep their lengths: J = Q R with R unit upper triangular, and X = R^-1 (Q^T Q)^-1 Q^T. As with orthonormal
// columns, Q^T Q differs from a diagonal matrix by rounding times the condition of J (Bjorck), and so does X from the inverse,
// relative to its size. All products of a step are independent of each other, so that a processor computes them at the same time.
template <int N, int rows, class V> STEP V inverse(Rows<rows, V> (&J)[N], V (&X)[N * rows]) {
    V R[N][N], w[N];
    in_turn<0, N>([&](auto k) IN_PLACE {
        V product[N];
        in_turn<k, N>([&](auto l) IN_PLACE { product[l] = dot_in_two(J[k], J[l]); });
        w[k] = inverse(product[k] + TINY);
        in_turn<k + 1, N>([&](auto l) IN_PLACE {
            R[k][l] = product[l] * w[k];
            in_turn<0, rows>([&](auto i) IN_PLACE { J[l][i] -= R[k][l] * J[k][i]; });
        });
    });
    V square = 0.0;
    in_turn<0, N>([&](auto up) IN_PLACE {
        constexpr int k = N - 1 - up;
        in_turn<0, rows>([&](auto i) IN_PLACE {
            V x = w[k] * J[k][i];
            in_turn<k + 1, N>([&](auto l) IN_PLACE { x -= R[k][l] * X[rows * l + i]; });
            X[rows * k + i] = x;
            square += x * x;
        });
    });
    return inverse_sqrt(square);
}

// Of real numbers as of complex ones.
STEP double conj(double a) { return a; }
STEP double square(double a) { return a * a; }
STEP double scaled(double f, double a) { return f * a; }

// a* b, the conjugates of a.
template <int R, class V> STEP V inner_product(const Rows<R, V>& a, const Rows<R, V>& b) {
    V sum = conj(a[0]) * b[0];
    for (int i = 1; i < R; ++i) sum += conj(a[i]) * b[i];
    return sum;
}
template <int R, class V> STEP auto square_of(const Rows<R, V>& a) {
    auto sum = square(a[0]);
    for (int i = 1; i < R; ++i) sum += square(a[i]);
    return sum;
}

// J = Q R; J becomes Q. weight: one over R's diagonal.
template <int N, int rows, class V> struct OrthogonalOf {
    Rows<rows, V> column[N];
    V R[N][N];
    decltype(square(R[0][0])) weight[N];
};
template <int N, int rows, class V> PART void make_orthogonal(const Rows<rows, V> (&J)[N], OrthogonalOf<N, rows, V>& f) {
    for (int k = 0; k < N; ++k) f.column[k] = J[k];
#pragma GCC unroll 1
    for (int k = 0; k < N; ++k) {
        f.weight[k] = 1.0 / sqrt(square_of(f.column[k]) + TINY);
        for (int i = 0; i < rows; ++i) f.column[k][i] = scaled(f.weight[k], f.column[k][i]);
#pragma GCC unroll 1
        for (int l = k + 1; l < N; ++l) {
            f.R[k][l] = inner_product(f.column[k], f.column[l]);
            for (int i = 0; i < rows; ++i) f.column[l][i] = f.column[l][i] - f.R[k][l] * f.column[k][i];
        }
    }
}

// The smallest singular value of J and its right singular vector.
template <int N> struct Weakest {
    double value, direction[N];
};

// Inverse iteration on the triangular factor of J.
template <int N, int rows> PART Weakest<N> weakest(const Rows<rows, double> (&J)[N]) {
    OrthogonalOf<N, rows, double> f;
    make_orthogonal(J, f);
    double x[N], y[N];
    for (double& each : f.weight) each = min(each, 1e30);
    Weakest<N> out;
    for (double& each : x) each = 1.0;
    for (int round = 0; round < 4; ++round) {
        double square = 0.0;
        for (int i = 0; i < N; ++i) {
            double rest = x[i];
            for (int j = 0; j < i; ++j) rest -= f.R[j][i] * y[j];
            y[i] = rest * f.weight[i];
        }
        for (int i = N - 1; i >= 0; --i) {
            double rest = y[i];
            for (int j = i + 1; j < N; ++j) rest -= f.R[i][j] * x[j];
            x[i] = rest * f.weight[i];
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
