// Forward kinematics and Jacobian of chains of any number of joints, in blocks of joint vectors.
#include "arm/kinematics.hpp"
#include "chain_arm.hpp"
#include "families/blocks.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Calls each(k, frame of joint k before it moves) for every joint of `many` consecutive joint vectors; the last one fills the
// remaining lanes. Returns the frame of the tip.
template <class Each> STEP Frame<Block> walk(const ChainArm& arm, const double* Q, int many, const Each& each) {
    Frame<Block> at = constant_frame<Block>(arm.step[0]);
    for (int k = 0; k < arm.joints; ++k) {
        Block q;
        for (int i = 0; i < BLOCK; ++i) q.set(i, Q[arm.joints * (i < many ? i : many - 1) + k]);
        each(k, at);
        at = beyond(arm.slides[k] ? Frame<Block>{at.R, at.p + q * at.R.z} : turned(at, cos_sin_of_any(q)), arm.step[k + 1]);
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
        if (many == BLOCK) return store_rows<Write::plain>(rows, T + 16 * from);
        double part[16 * BLOCK];
        store_rows<Write::plain>(rows, part);
        __builtin_memcpy(T + 16 * from, part, 128u * unsigned(many));
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

extern const ChainFunctions chain_functions = {poses, jacobians, axes};

}  // namespace urdf_ik::URDF_IK_LEVEL
