// A proof that Newton's method at a joint vector, real or complex, leads to a root of the loop equation: the affine-covariant
// theorem of Kantorovich (Deuflhard, Newton Methods for Nonlinear Problems, 2004, theorem 2.1), with an approximate inverse.
//
// f is the map of loop.hpp at the joint vector, zeta its derivative, C an approximate inverse of zeta with rows C_i, |d| the
// largest |d_k|. Then
//   eta >= |C f|,  E >= |1 - C zeta|,
//   K(r) >= |C (f'(a) - f'(b))| / |a - b| in the ball of radius r:  max_i (sum_j |C_i H_jj| + 2 sum_{j<k} |C_i H_jk|)
//           + max_i |C_i|_2 S^3 r e^(S r),  S = sum_k sqrt(|v_k|^2 + 2 |w_k|^2) the Frobenius norms of the twists,
// and if (1 - E)^2 >= 2 K(r) eta for r = 4 eta, there is one root within inner, and no other within outer,
//   inner, outer = (1 - E -+ sqrt((1 - E)^2 - 2 K eta)) / K,  at most r.
// The first bound that is tried leaves H out: |C_i H_jk| <= |C_i|_2 times the product of two twists' norms.
#pragma once

#include "certify/loop.hpp"
#include "numbers/least_squares.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The bounds hold for S r up to LARGEST_BALL, where e^(S r) is below GROWTH, and Y's trace stays within 0.7 of 3:
// sqrt(3) (e^0.3 - 1) < 0.61.
inline constexpr double LARGEST_BALL = 0.3, GROWTH = 1.35;
// The squared distance of X's trace from 3, rounding included, stays below 1.
inline constexpr double SAME_BRANCH = 0.9;

// One lane per root. holds: whether there is a root within inner, and no other within outer.
struct Certificate {
    Block eta, E, K, inner, outer;
    Block error;  // of the loop
    MaskOf<Block> holds;
};

// The triangular factor of the twists, and their inverse by modified Gram-Schmidt: rows C_i.
template <class V> struct Inverse {
    Six<V> row[6];
};

template <class V> using Orthogonal = OrthogonalOf<6, 6, V>;

// Newton's step: J x = e.
template <class V> STEP Six<V> newton_step(const Orthogonal<V>& f, Six<V> e) {
    Six<V> x;
    for (int k = 0; k < 6; ++k) {
        x[k] = inner_product(f.column[k], e);
        for (int i = 0; i < 6; ++i) e[i] = e[i] - x[k] * f.column[k][i];
    }
    for (int k = 5; k >= 0; --k) {
        for (int l = k + 1; l < 6; ++l) x[k] = x[k] - f.R[k][l] * x[l];
        x[k] = scaled(f.weight[k], x[k]);
    }
    return x;
}

// The loop at a block of joints, and its factors.
template <class V> PART void linearise(const Loop& loop, const V (&q)[6], LoopAt<V>& at, Orthogonal<V>& f) {
    Turn<V> turn[6];
    turns_of(q, turn);
    at = loop_at(loop, turn);
    make_orthogonal(at.twist, f);
}

// Newton's method from a block of complex joints, for `rounds` rounds, or until no lane in use moves by more than `enough`. Steps
// are limited to half a radian. to_here: finds the loop and its factors.
template <class F>
STEP void converge(CBlock (&z)[6], unsigned lanes, int rounds, double enough, const LoopAt<CBlock>& at, const Orthogonal<CBlock>& f,
                   const F& to_here) {
    for (int round = 0;; ++round) {
        to_here();
        if (round == rounds) return;
        const Six<CBlock> step = newton_step(f, at.error);
        Block size = square(step[0]);
        for (int k = 1; k < 6; ++k) size = max(size, square(step[k]));
        const Block shrink = min(Block(1.0), 0.5 / sqrt(size + TINY));
        for (int k = 0; k < 6; ++k) z[k] = z[k] * small_turn(scaled(shrink, step[k]));
        // What this step leaves is of the order of its square.
        if (!(bits(size > Block(enough * enough)) & lanes)) rounds = round + 1;
    }
}

template <class V> PART Inverse<V> inverse_of(const Orthogonal<V>& f) {
    Inverse<V> C;
#pragma GCC unroll 1
    for (int k = 5; k >= 0; --k) {
        for (int i = 0; i < 6; ++i) C.row[k][i] = conj(f.column[k][i]);
#pragma GCC unroll 1
        for (int l = k + 1; l < 6; ++l) {
            for (int i = 0; i < 6; ++i) C.row[k][i] = C.row[k][i] - f.R[k][l] * C.row[l][i];
        }
        for (int i = 0; i < 6; ++i) C.row[k][i] = scaled(f.weight[k], C.row[k][i]);
    }
    return C;
}

// max_i (sum_j |C_i H_jj| + 2 sum_{j<k} |C_i H_jk|), without rounding.
template <class V> PART Block second_derivatives(const Six<V> (&twist)[6], const Inverse<V>& C) {
    Block sum[6];
    for (Block& each : sum) each = 0.0;
#pragma GCC unroll 1
    for (int j = 0; j < 6; ++j) {
#pragma GCC unroll 1
        for (int k = j; k < 6; ++k) {
            const Six<V> H = second_derivative(twist[j], twist[k]);
            const double times = j == k ? 1.0 : 2.0;
            for (int i = 0; i < 6; ++i) sum[i] += times * above(dot(C.row[i], H));
        }
    }
    Block most = sum[0];
    for (int i = 1; i < 6; ++i) most = max(most, sum[i]);
    return most;
}

// The radii that follow from eta, E and K.
STEP void decide(Certificate& c, const Block& S, const Block& r) {
    const Block left = 1.0 - c.E, rest = left * left - 2.0 * c.K * c.eta;
    const Block spread = sqrt(max(rest, Block(0.0)));
    // Rounded up: the smaller root in the form without a difference.
    c.inner = SLACK_OF_SUMS * (2.0 * c.eta / (left + spread));
    c.outer = min(r, (left + spread) / c.K);
    c.holds = (left > Block(0.0)) & (rest > Block(0.0)) & (c.inner <= r) & (S * r <= Block(LARGEST_BALL));
}

// The rounding of X's rotation and position, and of a twist.
struct Rounding {
    Block of_rotation, of_position, of_twist;
};
STEP Block rounding_of_twist(const Loop& loop, const Growth& growth) {
    return ROUNDING_OF_TWIST * growth.side * growth.side * (2.0 * loop.length + 1.0);
}

// The certificate at a joint vector whose loop is `at`. f: its factors. ball: the bounds hold in it; there is no other root in it
// where outer is as large.
template <class V>
PART Certificate certify(const LoopAt<V>& at, const Orthogonal<V>& f, const Rounding& rounding, const Block& ball = 0.0) {
    const Inverse<V> C = inverse_of(f);
    Certificate out;
    const Block size = out.error = sqrt(square_of(at.error));
    const auto& [of_rotation, of_position, of_twist] = rounding;
    Block S = 0.0, longest_row = 0.0;
    for (int k = 0; k < 6; ++k) {
        Block linear = 0.0, angular = 0.0;
        for (int i = 0; i < 3; ++i) linear += square(at.twist[k][i]), angular += square(at.twist[k][i + 3]);
        S += sqrt(linear + 2.0 * angular) + 2.0 * of_twist;
    }
    out.eta = 0.0, out.E = 0.0;
#pragma GCC unroll 1
    for (int k = 0; k < 6; ++k) {
        const Six<V>& c = C.row[k];
        Block linear = 0.0, angular = 0.0, off = 0.0;
        for (int i = 0; i < 3; ++i) linear += square(c[i]), angular += square(c[i + 3]);
        const Block row = sqrt(linear + angular);
        longest_row = max(longest_row, row);
        // Eight operations in each product of six.
        out.eta = max(out.eta,
                      above(dot(c, at.error)) + sqrt(linear) * of_position + sqrt(angular) * of_rotation + 8.0 * UNIT * row * size);
        for (int j = 0; j < 6; ++j) {
            V each = dot(c, at.twist[j]);
            if (j == k) each = each - V(1.0);
            off += above(each);
        }
        out.E = max(out.E, off + row * (16.0 * UNIT * S + 6.0 * of_twist));
    }
    out.eta = SLACK_OF_SUMS * out.eta, out.E = SLACK_OF_SUMS * out.E + 16.0 * UNIT;
    const Block r = max(4.0 * out.eta, ball), third = GROWTH * longest_row * S * S * S * r;
    out.K = SLACK_OF_SUMS * (longest_row * S * S + third);
    decide(out, S, r);
    const auto near = square(at.off) < Block(SAME_BRANCH);
    if (any(!(out.holds & (out.outer >= ball)) & near)) {
        const Block H = second_derivatives(at.twist, C) + longest_row * S * (32.0 * UNIT * S + 12.0 * of_twist);
        out.K = SLACK_OF_SUMS * (H + third);
        decide(out, S, r);
    }
    out.holds = out.holds & near;
    return out;
}
template <class V>
STEP Certificate certify(const Loop& loop, const LoopAt<V>& at, const Orthogonal<V>& f, const Growth& growth,
                         const Block& ball = 0.0) {
    const Block rotation = ROUNDING_OF_ROTATION * growth.all, position = loop.rounding * growth.all;
    return certify(at, f, Rounding{rotation, position, rounding_of_twist(loop, growth)}, ball);
}

}  // namespace urdf_ik::URDF_IK_LEVEL
