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
    Six<Number> raw[6][6];
    for (int j = 0; j < 6; ++j) {
        const Vec<Number> w = {at.twist[j][3], at.twist[j][4], at.twist[j][5]};
        double each = 0.0;
        for (int i = 0; i < 3; ++i) each += square(at.twist[j][i]) + 2.0 * square(at.twist[j][i + 3]);
        out.spread += each, out.length[j] = sqrt(each) + 2.0 * of_twist;
        for (int k = j; k < 6; ++k) {
            const Vec<Number> a = cross(w, Vec<Number>{at.twist[k][0], at.twist[k][1], at.twist[k][2]});
            const Vec<Number> b = cross(w, Vec<Number>{at.twist[k][3], at.twist[k][4], at.twist[k][5]});
            raw[j][k] = raw[k][j] = {{a.x, a.y, a.z, 0.5 * b.x, 0.5 * b.y, 0.5 * b.z}};
        }
    }
    out.spread = sqrt(out.spread) + 4.0 * of_twist;
    for (int o = 0; o < 6; ++o) {
        out.g[o] = 0.0;
        for (int i = 0; i < 6; ++i) out.g[o] = out.g[o] - conj(out.J.left[o][i]) * at.error[i];
        for (int k = 0; k < 6; ++k) {
            out.A[k][o] = 0.0;
            for (int j = 0; j < 6; ++j) {
                for (int i = 0; i < 6; ++i) out.A[k][o] += conj(out.J.left[o][i]) * at.twist[j][i] * out.J.right[k][j];
            }
        }
        Number first[6][6], half[6][6];
        for (int j = 0; j < 6; ++j) {
            for (int k = 0; k < 6; ++k) {
                first[j][k] = 0.0;
                for (int i = 0; i < 6; ++i) first[j][k] += conj(out.J.left[o][i]) * raw[j][k][i];
            }
        }
        for (int a = 0; a < 6; ++a) {
            for (int k = 0; k < 6; ++k) {
                half[a][k] = 0.0;
                for (int j = 0; j < 6; ++j) half[a][k] += out.J.right[a][j] * first[j][k];
            }
        }
        for (int a = 0; a < 6; ++a) {
            for (int b = 0; b < 6; ++b) {
                out.H[o][a][b] = 0.0;
                for (int k = 0; k < 6; ++k) out.H[o][a][b] += half[a][k] * out.J.right[b][k];
            }
        }
    }
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
