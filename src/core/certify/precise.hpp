// Certificates of roots far from real, or beside a singularity. With |Im q| up to 10 rad, or a Jacobian that all but loses a rank,
// the loop's rounding in doubles exceeds what a certificate allows, so the loop and its twists are computed in numbers of twice the
// digits.
//
// The rotations of the steps and of the target are then those nearest to the stored ones. The bounds of loop.hpp hold with the
// unit of these numbers. What remains is the rounding of twists to doubles.
#pragma once

#include "certify/single.hpp"
#include "numbers/doubled.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A rigid motion: rotation by rows, translation.
struct DoubledMotion {
    Doubled R[3][3], t[3];
};
using Precise = Complexes<Doubled>;

// A constant motion as a frame, and the frame after a constant motion.
template <class V> STEP Frame<V> constant_frame(const DoubledMotion& m) {
    const auto column = [&](int k) { return Vec<V>{{m.R[0][k], 0.0}, {m.R[1][k], 0.0}, {m.R[2][k], 0.0}}; };
    return {{column(0), column(1), column(2)}, {{m.t[0], 0.0}, {m.t[1], 0.0}, {m.t[2], 0.0}}};
}
PART Frame<Precise> beyond(const Frame<Precise>& at, const DoubledMotion& m) {
    const auto combined = [&](const Doubled& a, const Doubled& b, const Doubled& c) {
        const auto sum = [&](const Precise& x, const Precise& y, const Precise& z) {
            return Precise{a * x.re + b * y.re + c * z.re, a * x.im + b * y.im + c * z.im};
        };
        const auto& [x, y, z] = at.R;
        return Vec<Precise>{sum(x.x, y.x, z.x), sum(x.y, y.y, z.y), sum(x.z, y.z, z.z)};
    };
    return {{combined(m.R[0][0], m.R[1][0], m.R[2][0]), combined(m.R[0][1], m.R[1][1], m.R[2][1]),
             combined(m.R[0][2], m.R[1][2], m.R[2][2])},
            at.p + combined(m.t[0], m.t[1], m.t[2])};
}

// Towards the nearest rotation: a step of Newton's method squares what orthogonality lacks, and leaves its own rounding, ten units.
PART void make_rotation(Doubled (&R)[3][3]) {
    Doubled square[3][3], out[3][3];  // R^T R
    for (int k = 0; k < 3; ++k) {
        for (int j = 0; j < 3; ++j) square[k][j] = R[0][k] * R[0][j] + R[1][k] * R[1][j] + R[2][k] * R[2][j];
    }
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            out[i][j] = 0.5 * (3.0 * R[i][j] - (R[i][0] * square[0][j] + R[i][1] * square[1][j] + R[i][2] * square[2][j]));
        }
    }
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) R[i][j] = out[i][j];
    }
}

// The motion with the rotation nearest to the stored one, which is orthogonal to 3e-14.
PART DoubledMotion precise(const Motion& m, double size) {
    DoubledMotion out;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) out.R[i][j] = m.R[i][j];
        out.t[i] = Doubled(m.t[i]) / Doubled(size);
    }
    for (int round = 0; round < 2; ++round) make_rotation(out.R);
    return out;
}

using PreciseLoop = LoopOf<DoubledMotion>;
PART PreciseLoop precise_loop(const Written<6>& arm, const Frame<double>& goal) {
    DoubledMotion step[7];
    for (int k = 0; k < 7; ++k) step[k] = precise(arm.step[k], arm.size);
    return loop_of_steps(step, precise(motion_of(goal), arm.size));
}

// The unit of the bounds: that of the numbers, and the rounding of rotations.
inline constexpr double PRECISE_UNIT = 16.0 * DOUBLED_UNIT;
// The ball without another root is looked for up to this radius: larger than the rounding of z, small against the third derivatives
// of most roots.
inline constexpr double PRECISE_BALL = 1e-9;
// Rounds of Newton's method from where doubles converged.
inline constexpr int PRECISE_ROUNDS = 3;

// Certifies the roots that the lanes in use have converged to; z: e^(i q), which Newton's method moves. loop: in doubles.
// A ball is half as large as the one without another root, instead of the smallest.
PART Certificate certify_precisely(const Loop& loop, const PreciseLoop& precise, CBlock (&z)[6], unsigned lanes, Growth& growth) {
    LoopAt<CBlock> at;
    Orthogonal<CBlock> f;
    converge(z, lanes, PRECISE_ROUNDS, 0.0, at, f, [&] {
        for (unsigned rest = lanes; rest; rest &= rest - 1) {
            const int l = __builtin_ctz(rest);
            Turn<Precise> turn[6];
            for (int k = 0; k < 6; ++k) turn[k] = turn_of(Precise{z[k].re[l], z[k].im[l]});
            const LoopAt<Precise> here = loop_at(precise, turn);
            // The first one is in the lanes that are not in use, too.
            const auto put = [&](CBlock& to, const Precise& a) {
                if (rest == lanes) to = {a.re.hi, a.im.hi};
                to.re.set(l, a.re.hi), to.im.set(l, a.im.hi);
            };
            for (int i = 0; i < 6; ++i) {
                for (int k = 0; k < 6; ++k) put(at.twist[k][i], here.twist[k][i]);
                put(at.error[i], here.error[i]);
            }
            put(at.off, here.off);
        }
        make_orthogonal(at.twist, f);
    });
    growth = growth_of(z);
    Block longest = 0.0;
    for (const Six<CBlock>& each : at.twist) longest = max(longest, square_of(each));
    const double small = PRECISE_UNIT / UNIT;
    const Rounding rounding = {small * ROUNDING_OF_ROTATION * growth.all, small * loop.rounding * growth.all,
                               2.0 * UNIT * sqrt(longest) + small * rounding_of_twist(loop, growth)};
    Certificate out = certify(at, f, rounding, PRECISE_BALL);
    out.inner = max(out.inner, 0.5 * out.outer);
    return out;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
