// The loop equation at one complex joint vector to second order, in the directions of its Jacobian's singular values.
#pragma once

#include "certificate/loop.hpp"
#include "certificate/svd.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Rounding of sums of products of six numbers in transformed derivatives, relative to their norms.
inline constexpr double ROUNDING_OF_FORMS = 100.0 * UNIT;

// The loop at one complex joint vector, in the directions of its singular values.
struct Local {
    Number q[6];                // joint values
    Svd<6, 6> J;
    Number g[6], A[6][6];       // A[k][i]: row i of column k
    Number H[6][6][6];          // second derivatives: output, input, input
    Six<Number> twist[6];
    double rounding, spread;    // of f; s of the third derivatives
    double length[6];           // of the twists: sqrt(|v|^2 + 2 |w|^2)
    bool near;                  // whether X's trace is near 3
};

// f and J at q, without what clusters need beyond.
STEP LoopAt<Number> loop_at(const Loop& loop, const Number (&q)[6]) {
    Turn<Number> turn[6];
    for (int k = 0; k < 6; ++k) {
        // A real angle stays exactly real.
        const Turn<double> t = exact_turn(q[k].re);
        const double length = exponential(-q[k].im);
        turn[k] = q[k].im == 0.0 ? Turn<Number>{t.c, t.s} : turn_of(Number(length * t.c, length * t.s));
    }
    return loop_at(loop, turn);
}

// The singular values of J: in real numbers at real joint vectors.
PART void decompose(const LoopAt<Number>& at, Svd<6, 6>& out) {
    Number columns[6][6];
    double real[6][6], off = 0.0;
    for (int k = 0; k < 6; ++k) {
        for (int i = 0; i < 6; ++i) columns[k][i] = at.twist[k][i], real[k][i] = columns[k][i].re, off += abs(columns[k][i].im);
    }
    if (off > 0.0) return svd(columns, out);
    Svd<6, 6, double> found;
    svd(real, found);
    for (int k = 0; k < 6; ++k) {
        for (int i = 0; i < 6; ++i) out.left[k][i] = found.left[k][i], out.right[k][i] = found.right[k][i];
        out.s[k] = found.s[k];
    }
}

// Real or complex numbers.
template <class V> STEP V part(const Number& a) {
    if constexpr (std::is_same_v<V, double>) return a.re;
    else return a;
}
STEP bool is_real(const Number (&q)[6]) {
    double off = 0.0;
    for (const Number& each : q) off += abs(each.im);
    return off == 0.0;
}

// g, A and H in the directions of the singular values.
template <class V> PART void transform(const LoopAt<Number>& at, Local& out) {
    Six<V> twist[6];
    V left[6][6], right[6][6], raw[6][6][6];  // left: conjugate
    for (int k = 0; k < 6; ++k) {
        for (int i = 0; i < 6; ++i) {
            twist[k][i] = part<V>(at.twist[k][i]);
            left[k][i] = conj(part<V>(out.J.left[k][i])), right[k][i] = part<V>(out.J.right[k][i]);
        }
    }
    for (int j = 0; j < 6; ++j) {
        for (int k = j; k < 6; ++k) {
            const Six<V> each = second_derivative(twist[j], twist[k]);
            for (int i = 0; i < 6; ++i) raw[j][k][i] = raw[k][j][i] = each[i];
        }
    }
    const auto dot6 = [](const auto& a, const auto& b) {
        V sum = a[0] * b[0];
        for (int i = 1; i < 6; ++i) sum += a[i] * b[i];
        return sum;
    };
    for (int o = 0; o < 6; ++o) {
        V g = 0.0, first[6][6], half[6][6], row[6];
        for (int i = 0; i < 6; ++i) g = g - left[o][i] * part<V>(at.error[i]);
        out.g[o] = g;
        for (int j = 0; j < 6; ++j) row[j] = dot6(left[o], twist[j]);
        for (int k = 0; k < 6; ++k) out.A[k][o] = dot6(row, right[k]);
        for (int j = 0; j < 6; ++j) {
            for (int k = j; k < 6; ++k) first[j][k] = first[k][j] = dot6(left[o], raw[j][k]);
        }
        for (int a = 0; a < 6; ++a) {
            for (int k = 0; k < 6; ++k) half[a][k] = dot6(right[a], first[k]);
        }
        for (int a = 0; a < 6; ++a) {
            for (int b = a; b < 6; ++b) out.H[o][a][b] = out.H[o][b][a] = dot6(half[a], right[b]);
        }
    }
}

// The rest of the numbers at q; J is there.
PART void localise(const Loop& loop, const LoopAt<Number>& at, const Number (&q)[6], Local& out) {
    double growth = 0.0, side[2] = {0.0, 0.0};
    for (int k = 0; k < 6; ++k) {
        growth += abs(q[k].im), side[k / 3] += abs(q[k].im), out.q[k] = q[k];
        out.twist[k] = at.twist[k];
    }
    const double M = exponential(growth), m = exponential(max(side[0], side[1])), l = loop.length;
    out.rounding = M * sqrt(ROUNDING_OF_ROTATION * ROUNDING_OF_ROTATION + loop.rounding * loop.rounding);
    const double of_twist = ROUNDING_OF_TWIST * m * m * (2.0 * l + 1.0);
    out.near = square(at.off) < SAME_BRANCH;
    out.spread = 0.0;
    for (int j = 0; j < 6; ++j) {
        double each = 0.0;
        for (int i = 0; i < 3; ++i) each += square(at.twist[j][i]) + 2.0 * square(at.twist[j][i + 3]);
        out.spread += each, out.length[j] = sqrt(each) + 2.0 * of_twist;
    }
    out.spread = sqrt(out.spread) + 4.0 * of_twist;
    if (is_real(q)) transform<double>(at, out);
    else transform<Number>(at, out);
}

// The Frobenius norm of a part of H: outputs from..to, inputs in two ranges.
STEP double norm_of(const Local& at, int o0, int o1, int a0, int a1, int b0, int b1) {
    double sum = 0.0;
    for (int o = o0; o < o1; ++o) {
        for (int a = a0; a < a1; ++a) {
            for (int b = b0; b < b1; ++b) sum += square(at.H[o][a][b]);
        }
    }
    return sqrt(sum) + ROUNDING_OF_FORMS * at.spread * at.spread;
}
// The same of A: columns, rows. `without`: the diagonal left out.
STEP double norm_of(const Local& at, int k0, int k1, int o0, int o1, bool without = false) {
    double sum = 0.0;
    for (int k = k0; k < k1; ++k) {
        for (int o = o0; o < o1; ++o) {
            if (!(without && k == o)) sum += square(at.A[k][o]);
        }
    }
    return sqrt(sum) + ROUNDING_OF_FORMS * at.spread;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
