// The complex solutions of the elimination: joints from the complex roots of its determinant.
//
// The same steps as for real roots (hidden_joint.hpp) in complex numbers. Joints are stored as z = e^(i angle).
#pragma once

#include "certify/loop.hpp"
#include "families/general/hidden_joint.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// e^(i angle) from a multiple of the cosine and the sine: the longer of c + i s and c - i s is exact to rounding, and they are
// inverse to each other up to the multiple's square.
STEP CBlock on_circle(const CBlock& c, const CBlock& s) {
    const CBlock is = {-s.im, s.re}, up = c + is, down = c - is;
    const Block a = square(up), b = square(down);
    // up / sqrt(up down) without the root: the multiple is one where both are given exactly.
    return select(a > b, up, inverse(down));
}
// The ratio of two proportional pairs: (b0, b1) = ratio (a0, a1), each by its longer entry.
STEP CBlock ratio_of(const CBlock& a0, const CBlock& a1, const CBlock& b0, const CBlock& b1) {
    const auto first = square(a0) + square(b0) > square(a1) + square(b1);
    return select(first, b0, b1) * inverse(select(first, a0, a1));
}

// Joints that the null vectors of the matrices at the hidden turns lead to; all joints turn.
PART void complex_joints(const EliminationVariant& at, const Frame<double>& motion, const CBlock (&x)[SIZE], const CBlock& hidden,
                         CBlock (&z)[6]) {
    const Frame<CBlock> G = spread<CBlock>(motion);
    const int kept = (at.first + 3) % 6, kept_too = (at.first + 4) % 6, last = (at.first + 5) % 6;
    CBlock values[6];
    Value<CBlock> turn[6] = {};
    // The null vector is (1, cos, sin) of joint a + 3 times the halves: (cos, sin) of half of joint a + 4 and of three halves.
    Block longest = 0.0;
    CBlock halves[4] = {};
    for (int j = 0; j < 3; ++j) {
        Block all = 0.0;
        for (int i = 0; i < 4; ++i) all += square(x[4 * j + i]);
        const auto longer = all > longest;
        longest = select(longer, all, longest);
        for (int i = 0; i < 4; ++i) halves[i] = select(longer, x[4 * j + i], halves[i]);
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
    values[kept_too] = select(rises, ratio_of(down, up, up, up_3), ratio_of(down_3, down, down, up));
    values[last] = hidden;
    turn[kept].turn = turn_of(values[kept]), turn[kept_too].turn = turn_of(values[kept_too]), turn[last].turn = turn_of(hidden);
    add_first_values(at, G, turn, [&](int joint, const CBlock& cosine, const CBlock& sine) {
        values[joint] = on_circle(cosine, sine);
        return Value<CBlock>{turn_of(values[joint]), 0.0};
    });
    for (int j = 0; j < 6; ++j) z[j] = values[at.reversed ? 5 - j : j];
}

}  // namespace urdf_ik::URDF_IK_LEVEL
