// Least-squares inverses of the Jacobians of one to seven joints, in blocks of joint vectors.
#include "chain_arm.hpp"
#include "families/blocks.hpp"
#include "families/seven_joints/swivel.hpp"
#include "numbers/least_squares.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The derivative of an S-R-S arm's swivel angle by the joints, from axes and Jacobian in the base. Axis 4 turns about the unit
// vector w from shoulder to wrist, and the normal of the plane of w and axis 1 turns too: the angle's rate is that of the first
// less that of the second. NaN where the wrist lies on axis 1, where the angle jumps.
STEP Rows<7, Block> swivel_slopes(const SwivelEnds& ends, const Frame<Block> (&joints)[7], const Frame<Block>& tip) {
    const Vec<Block> wrist = tip.p + combine(tip.R, ends.wrist[0], ends.wrist[1], ends.wrist[2]);
    const Vec<Block> up = {ends.up[0], ends.up[1], ends.up[2]}, axis = joints[3].R.z;
    const Vec<Block> W = wrist - Vec<Block>{ends.shoulder[0], ends.shoulder[1], ends.shoulder[2]};
    const Block per_length = inverse_sqrt(dot(W, W) + TINY);
    const Vec<Block> w = per_length * W, across = cross(w, axis), normal = cross(up, W);
    const Block aside = dot(normal, normal), wide = quotient(Block(1.0), dot(across, across) + TINY);
    // What the velocity of the wrist, and the turning of axis 4, count.
    const Vec<Block> by_speed =
        (dot(axis, w) * per_length * wide) * across + quotient(Block(1.0), aside + TINY) * cross(cross(w, normal), up);
    const Vec<Block> by_turning = wide * cross(axis, across);
    const auto off_axis = aside > Block(HALF_OF_THE_DIGITS * HALF_OF_THE_DIGITS) * dot(W, W);
    Rows<7, Block> slope;
    for (int k = 0; k < 7; ++k) {
        Vec<Block> by = cross(Block(-1.0) * (wrist - joints[k].p), by_speed);
        if (k < 3) by = by + by_turning;
        slope[k] = select(off_axis, dot(joints[k].R.z, by), __builtin_nan(""));
    }
    return slope;
}

// Joint vectors for one block, one per lane, and where their inverses go.
struct Lanes {
    const double* from[BLOCK];
    double* to[BLOCK];
    int many = 0;
};

// The joints' axes and their origins, and the tip's frame. All turns come first: they do not wait for each other.
PART Frame<Block> axes_of(const ChainArm& arm, const Lanes& lanes, Frame<Block> (&joints)[7]) {
    Block q[7];
    Turn<Block> turn[7];
#pragma GCC unroll 1
    for (int k = 0; k < arm.joints; ++k) {
        for (int i = 0; i < BLOCK; ++i) q[k].set(i, lanes.from[i][k]);
        turn[k] = cos_sin_of_any(q[k]);
    }
    Frame<Block> at = constant_frame<Block>(arm.step[0]);
#pragma GCC unroll 1
    for (int k = 0; k < arm.joints; ++k) {
        joints[k].p = at.p, joints[k].R.z = at.R.z;
        at = beyond(arm.slides[k] ? Frame<Block>{at.R, at.p + q[k] * at.R.z} : turned(at, turn[k]), arm.step[k + 1]);
    }
    return at;
}

// M: how many columns are inverted. Seven joints have six of them where a joint is held, and seven with the swivel angle.
template <int N, int M> PART void invert(const ChainArm& arm, const Lanes& lanes, const InverseScale& scale) {
    constexpr int rows = M == 7 ? 7 : 6, width = N == 7 ? 7 : 6;
    const double share = 1.0 / scale.size;
    Frame<Block> joints[7];
    const Frame<Block> tip = axes_of(arm, lanes, joints);
    Rows<rows, Block> J[M];
    Six<Block> held;
    const auto free = [&](int k) IN_PLACE { return N == M || k < scale.held ? k : k + 1; };
#pragma GCC unroll 7
    for (int k = 0; k < M; ++k) {
        const Six<Block> column = jacobian_column(joints[free(k)], arm.slides[free(k)], tip.p, share);
        for (int r = 0; r < 6; ++r) J[k][r] = column[r];
    }
    if constexpr (M == 7) {
        const Rows<7, Block> slopes = swivel_slopes(scale.swivel, joints, tip);
        in_turn<0, 7>([&](auto k) IN_PLACE { J[k][6] = slopes[k]; });
    }
    if constexpr (N != M) held = jacobian_column(joints[scale.held], arm.slides[scale.held], tip.p, share);
    Block own[M * rows], x[N * width];
    const Block gain = select(inverse(J, own) > Block(scale.singular), Block(1.0), __builtin_nan(""));
    const auto unit = [&](int k) IN_PLACE { return arm.slides[k] ? scale.size : 1.0; };
#pragma GCC unroll 7
    for (int k = 0; k < M; ++k) {
        Block* const row = x + width * free(k);
        const Block angular = unit(free(k)) * gain, linear = share * angular;
        for (int c = 0; c < rows; ++c) row[c] = own[rows * k + c] * (c < 3 ? linear : angular);
        if constexpr (N != M) {
            Block sum = 0.0;
            for (int c = 0; c < 6; ++c) sum -= own[6 * k + c] * held[c];
            row[6] = sum * (angular * (1.0 / unit(scale.held)));
        }
    }
    if constexpr (N != M) {
        for (int c = 0; c < 7; ++c) x[width * scale.held + c] = (c < 6 ? 0.0 : 1.0) * gain;
    }
    store_rows(x, lanes.to);
}

// Joint vectors that are NaN are left out, so that all lanes have work.
static void inverses(const ChainArm& arm, const double* Q, const InverseScale& scale, long m, double* X) {
    constexpr decltype(&invert<1, 1>) of[] = {invert<1, 1>, invert<2, 2>, invert<3, 3>, invert<4, 4>,
                                              invert<5, 5>, invert<6, 6>, invert<7, 6>, invert<7, 7>};
    const auto invert_lanes = of[arm.joints == 7 && scale.held < 0 ? 7 : arm.joints - 1];
    const int numbers = arm.joints * (arm.joints == 7 ? 7 : 6);
    double unread[7 * 7];
    Lanes lanes;
    const auto solve = [&] {
        for (int l = lanes.many; l < BLOCK; ++l) lanes.from[l] = lanes.from[0], lanes.to[l] = unread;
        invert_lanes(arm, lanes, scale);
        lanes.many = 0;
    };
    for (long i = 0; i < m; ++i, Q += arm.joints, X += numbers) {
        if (!(*Q == *Q)) {
            for (int k = 0; k < numbers; ++k) X[k] = __builtin_nan("");
            continue;
        }
        lanes.from[lanes.many] = Q, lanes.to[lanes.many] = X;
        if (++lanes.many == BLOCK) solve();
    }
    if (lanes.many) solve();
}

extern const InverseFunctions inverse_functions = {inverses};

}  // namespace urdf_ik::URDF_IK_LEVEL
