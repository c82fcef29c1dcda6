// Forward kinematics and Jacobian of chains of any number of joints, in blocks of joint vectors.
#include "chain_arm.hpp"

#include "answers/blocks.hpp"
#include "arithmetic/least_squares.hpp"
#include "kinematics/kinematics.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The pose of the tip for `many` joint vectors, one per lane. Calls each(k, frame of joint k before it moves) for every joint.
template <class Each> STEP Frame<Block> walk(const ChainArm& arm, const double* Q, int many, const Each& each) {
    Frame<Block> at = constant_frame<Block>(arm.step[0]);
    for (int k = 0; k < arm.joints; ++k) {
        each(k, at);
        Block q = 0.0;
        for (int i = 0; i < many; ++i) q.set(i, Q[arm.joints * i + k]);
        at = arm.slides[k] ? Frame<Block>{at.R, at.p + q * at.R.z} : turned(at, cos_sin_of_any(q));
        at = beyond(at, arm.step[k + 1]);
    }
    return at;
}

template <class Do> STEP void in_blocks(long m, const Do& block) {
    for (long from = 0; from < m; from += BLOCK) block(from, int(m - from < BLOCK ? m - from : BLOCK));
}

static void poses(const ChainArm& arm, const double* Q, long m, double* T) {
    in_blocks(m, [&](long from, int many) {
        const Frame<Block> tip = walk(arm, Q + arm.joints * from, many, [](int, const Frame<Block>&) {});
        const Rot<Block>& R = tip.R;
        const Block rows[16] = {R.x.x, R.y.x, R.z.x, tip.p.x, R.x.y, R.y.y, R.z.y, tip.p.y,
                                R.x.z, R.y.z, R.z.z, tip.p.z, 0.0,   0.0,   0.0,   1.0};
        if (many == BLOCK) return store_rows<Write::plain, 16>(rows, T + 16 * from);
        double part[16 * BLOCK];
        store_rows<Write::plain, 16>(rows, part);
        __builtin_memcpy(T + 16 * from, part, 128 * many);
    });
}

// Writes the joint axes for `many` joint vectors. Returns the positions of the tips.
STEP Vec<Block> axes_of(const ChainArm& arm, const double* Q, int many, double* J) {
    const int n = arm.joints;
    return walk(arm, Q, many,
                [&](int k, const Frame<Block>& joint) {
                    const Block column[6] = {joint.p.x, joint.p.y, joint.p.z, joint.R.z.x, joint.R.z.y, joint.R.z.z};
                    for (int r = 0; r < 6; ++r) {
                        for (int i = 0; i < many; ++i) J[n * (6 * i + r) + k] = column[r][i];
                    }
                })
        .p;
}

static void axes(const ChainArm& arm, const double* Q, long m, double* J) {
    in_blocks(m, [&](long from, int many) { axes_of(arm, Q + arm.joints * from, many, J + 6 * arm.joints * from); });
}

static void jacobians(const ChainArm& arm, const double* Q, long m, double* J) {
    const int n = arm.joints;
    in_blocks(m, [&](long from, int many) {
        double* to = J + 6 * n * from;
        const Vec<Block> tips = axes_of(arm, Q + n * from, many, to);
        for (int i = 0; i < many; ++i, to += 6 * n) {
            const Vec<double> tip = {tips.x[i], tips.y[i], tips.z[i]};
            for (int k = 0; k < n; ++k) {
                Frame<double> joint;
                joint.p = {to[k], to[n + k], to[2 * n + k]}, joint.R.z = {to[3 * n + k], to[4 * n + k], to[5 * n + k]};
                const Six<double> column = jacobian_column(joint, arm.slides[k], tip, 1.0);
                for (int r = 0; r < 6; ++r) to[n * r + k] = column[r];
            }
        }
    });
}

template <int N>
static void inverses_of(const ChainArm& arm, const double* Q, const double* row, long apart, const InverseScale& scale, long m,
                        double* X) {
    constexpr int rows = N == 7 ? 7 : 6, numbers = N * rows;
    const double share = 1.0 / scale.size;
    in_blocks(m, [&](long from, int many) {
        Frame<Block> joints[N];
        const Vec<Block> tip = walk(arm, Q + N * from, many, [&](int k, const Frame<Block>& joint) {
                                   joints[k].p = joint.p, joints[k].R.z = joint.R.z;
                               }).p;
        Rows<rows, Block> J[N];
        for (int k = 0; k < N; ++k) {
            const Six<Block> column = jacobian_column(joints[k], arm.slides[k], tip, share);
            for (int r = 0; r < 6; ++r) J[k][r] = column[r];
            if constexpr (rows == 7) {
                Block more = 0.0;
                for (int i = 0; i < many; ++i) more.set(i, row[apart * (from + i) + k]);
                J[k][6] = arm.slides[k] ? more * scale.size : more;
            }
        }
        Block x[numbers];
        const auto regular = inverse(J, x) > Block(scale.singular);
        for (int k = 0; k < N; ++k) {
            for (int c = 0; c < rows; ++c) {
                const double unit = (arm.slides[k] ? scale.size : 1.0) * (c < 3 ? share : 1.0);
                x[rows * k + c] = select(regular, x[rows * k + c] * unit, __builtin_nan(""));
            }
        }
        if (many == BLOCK) return store_rows<Write::plain, numbers>(x, X + numbers * from);
        double part[numbers * BLOCK];
        store_rows<Write::plain, numbers>(x, part);
        __builtin_memcpy(X + numbers * from, part, sizeof(double) * numbers * many);
    });
}

static void inverses(const ChainArm& arm, const double* Q, const double* row, long apart, const InverseScale& scale, long m,
                     double* X) {
    constexpr decltype(&inverses_of<1>) of[] = {inverses_of<1>, inverses_of<2>, inverses_of<3>, inverses_of<4>,
                                                inverses_of<5>, inverses_of<6>, inverses_of<7>};
    of[arm.joints - 1](arm, Q, row, apart, scale, m, X);
}

extern const ChainFunctions chain_functions;
const ChainFunctions chain_functions = {poses, jacobians, axes, inverses};

}  // namespace urdf_ik::URDF_IK_LEVEL
