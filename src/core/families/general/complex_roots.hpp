// The complex solutions of the elimination: joints from the complex roots of its determinant.
//
// The same steps as for real roots (hidden_joint.hpp) in complex numbers. Joints are stored as z = e^(i angle).
#pragma once

#include "certificate/loop.hpp"
#include "families/general/hidden_joint.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A complex Householder reflection: makes column I zero below its diagonal.
template <int I> STEP void reflect(CBlock (&M)[SIZE][SIZE]) {
    constexpr int N = SIZE - I;
    CBlock v[N];
    Block all = TINY;
    for (int r = 0; r < N; ++r) v[r] = M[I][I + r], all += square(v[r]);
    const Block head = sqrt(square(v[0]) + TINY), length = sqrt(all), w = 1.0 / sqrt(all + length * head);
    // -v0 / |v0| times the column's length, so that v - alpha e has no cancellation.
    const CBlock alpha = scaled(-(length / head), v[0]);
    M[I][I] = alpha;
    v[0] = v[0] - alpha;
    for (int r = 0; r < N; ++r) v[r] = scaled(w, v[r]);
#pragma GCC unroll 1
    for (int j = I + 1; j < SIZE; ++j) {
        CBlock f = 0.0;
#pragma GCC unroll 12
        for (int r = 0; r < N; ++r) f += conj(v[r]) * M[j][I + r];
#pragma GCC unroll 12
        for (int r = 0; r < N; ++r) M[j][I + r] = M[j][I + r] - f * v[r];
    }
}
template <int I = 0> STEP void make_triangular(CBlock (&M)[SIZE][SIZE]) {
    if constexpr (I < SIZE - 1) {
        reflect<I>(M);
        make_triangular<I + 1>(M);
    }
}

// Unit vectors that are nearly null vectors of the matrices at the hidden turns t: inverse iteration on R* R.
PART void null_vectors(const Equations& A, const Turn<CBlock>& t, CBlock (&x)[SIZE]) {
    CBlock M[SIZE][SIZE], w[SIZE];
    matrix_at(A, t.c, t.s, M);
    make_triangular(M);
    Block longest = 0.0;
    for (int i = 0; i < SIZE; ++i) longest = max(longest, square(M[i][i]));
    const Block least = 1e-15 * sqrt(longest) + TINY;
    for (int i = 0; i < SIZE; ++i) {
        const auto small = square(M[i][i]) < least * least;
        w[i] = inverse(CBlock{select(small, least, M[i][i].re), select(small, Block(0.0), M[i][i].im)});
        x[i] = 1.0 + 0.1 * i * ((i % 3) - 1);
    }
    for (int round = 0; round < 2; ++round) {
        for (int i = 0; i < SIZE; ++i) {
            for (int j = 0; j < i; ++j) x[i] = x[i] - conj(M[i][j]) * x[j];
            x[i] = conj(w[i]) * x[i];
        }
        Block all = TINY;
        for (int i = SIZE - 1; i >= 0; --i) {
            for (int j = i + 1; j < SIZE; ++j) x[i] = x[i] - M[j][i] * x[j];
            x[i] = w[i] * x[i];
            all += square(x[i]);
        }
        const Block length = 1.0 / sqrt(all);
        for (auto& each : x) each = scaled(length, each);
    }
}

// e^(i angle) from a multiple of the cosine and the sine: the longer of c + i s and c - i s is exact to rounding, and they are
// inverse to each other up to the multiple's square.
STEP CBlock on_circle(const CBlock& c, const CBlock& s) {
    const CBlock is = {-s.im, s.re}, up = c + is, down = c - is;
    const Block a = square(up), b = square(down);
    // up / sqrt(up down) without the root: the multiple is one where both are given exactly.
    const auto ahead = a > b;
    const CBlock other = inverse(down);
    return {select(ahead, up.re, other.re), select(ahead, up.im, other.im)};
}
// The ratio of two proportional pairs: (b0, b1) = ratio (a0, a1), each by its longer entry.
STEP CBlock ratio_of(const CBlock& a0, const CBlock& a1, const CBlock& b0, const CBlock& b1) {
    const auto first = square(a0) + square(b0) > square(a1) + square(b1);
    const CBlock a = {select(first, a0.re, a1.re), select(first, a0.im, a1.im)};
    const CBlock b = {select(first, b0.re, b1.re), select(first, b0.im, b1.im)};
    return b * inverse(a);
}

// A point, moved backwards by joint j of the loop; and through joints a + 3, a + 4, a + 5 and G.
STEP Vec<CBlock> undone(const EliminationVariant& at, int j, const Turn<CBlock>& t, const Vec<CBlock>& v) {
    const Vec<CBlock> h = vec<CBlock>(at.axes[j]), p = vec<CBlock>(at.points[j]), x = v - p;
    return t.c * x - t.s * cross(h, x) + ((CBlock(1.0) - t.c) * dot(h, x)) * h + p;
}
STEP Vec<CBlock> other_side(const EliminationVariant& at, const Frame<CBlock>& G, const Turn<CBlock> (&turn)[6], Vec<CBlock> v) {
    for (int k = 0; k < 4; ++k) {
        if (k + at.first == 3) v = G.R * v + G.p;
        const int j = (at.first + 3 + k) % 6;
        if (k < 3) v = undone(at, j, turn[j], v);
    }
    return v;
}

// Joints that the null vectors of the matrices at the hidden turns lead to; all joints turn.
PART void complex_joints(const EliminationVariant& at, const Frame<double>& motion, const CBlock (&x)[SIZE], const CBlock& hidden,
                         CBlock (&z)[6]) {
    const auto wide = [](const Vec<double>& a) { return Vec<CBlock>{CBlock(a.x), CBlock(a.y), CBlock(a.z)}; };
    const Frame<CBlock> G = {{wide(motion.R.x), wide(motion.R.y), wide(motion.R.z)}, wide(motion.p)};
    const int first = at.first, kept = (first + 3) % 6, kept_too = (first + 4) % 6, last = (first + 5) % 6;
    CBlock values[6];
    Turn<CBlock> turn[6];
    // The null vector is (1, cos, sin) of joint a + 3 times the halves: (cos, sin) of half of joint a + 4 and of three halves.
    Block longest = 0.0;
    CBlock halves[4] = {};
    for (int j = 0; j < 3; ++j) {
        Block all = 0.0;
        for (int i = 0; i < 4; ++i) all += square(x[4 * j + i]);
        const auto longer = all > longest;
        longest = select(longer, all, longest);
        for (int i = 0; i < 4; ++i) {
            halves[i] = {select(longer, x[4 * j + i].re, halves[i].re), select(longer, x[4 * j + i].im, halves[i].im)};
        }
    }
    CBlock d[3];
    for (int j = 0; j < 3; ++j) {
        d[j] = 0.0;
        for (int i = 0; i < 4; ++i) d[j] += conj(halves[i]) * x[4 * j + i];
    }
    const CBlock one = inverse(d[0]);
    values[kept] = on_circle(one * d[1], one * d[2]);
    const auto i_times = [](const CBlock& a) { return CBlock{-a.im, a.re}; };
    // e^(-3 i phi / 2), e^(-i phi / 2), e^(i phi / 2), e^(3 i phi / 2), up to a multiple.
    const CBlock down = halves[0] - i_times(halves[1]), up = halves[0] + i_times(halves[1]);
    const CBlock down_3 = halves[2] - i_times(halves[3]), up_3 = halves[2] + i_times(halves[3]);
    const auto rises = square(up_3) > square(down_3);
    const CBlock rising = ratio_of(down, up, up, up_3), falling = ratio_of(down_3, down, down, up);
    values[kept_too] = {select(rises, rising.re, falling.re), select(rises, rising.im, falling.im)};
    values[last] = hidden;
    turn[kept] = turn_of(values[kept]), turn[kept_too] = turn_of(values[kept_too]), turn[last] = turn_of(hidden);
    const int k = first + 2;
    const Vec<CBlock> axis = vec<CBlock>(at.axes[k]), start = vec<CBlock>(at.points[k]), across = vec<CBlock>(at.across);
    const Vec<CBlock> p = other_side(at, G, turn, start), l = other_side(at, G, turn, start + axis) - p, m = cross(p, l);
    const CBlock h = 0.5 * dot(p, p), along = dot(p, l);
    const Vec<CBlock> rest = h * l - along * p;
    const CBlock w[LINE] = {CBlock(1.0), p.x, p.y, p.z, h, l.x, l.y, l.z, m.x, m.y, m.z, along, rest.x, rest.y, rest.z};
    const auto product = [&](int i) {
        CBlock sum = 0.0;
        for (int j = 0; j < LINE; ++j) sum += at.left_inverse[i][j] * w[j];
        return sum;
    };
    values[first] = on_circle(product(3), product(6));
    values[first + 1] = on_circle(product(1), product(2));
    turn[first] = turn_of(values[first]), turn[first + 1] = turn_of(values[first + 1]);
    Vec<CBlock> v = other_side(at, G, turn, start + across);
    v = undone(at, first, turn[first], v);
    v = undone(at, first + 1, turn[first + 1], v) - start;
    values[k] = on_circle(dot(across, v), dot(axis, cross(across, v)));
    for (int j = 0; j < 6; ++j) z[j] = values[at.reversed ? 5 - j : j];
}

}  // namespace urdf_ik::URDF_IK_LEVEL
