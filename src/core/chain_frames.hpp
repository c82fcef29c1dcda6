// Forward kinematics of chains of any number of joints, in blocks of joint vectors.
#pragma once

#include "answers/blocks.hpp"
#include "chain_arm.hpp"
#include "kinematics/kinematics.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The frame of the next joint, or of the tip, after joint k has moved by q.
STEP Frame<Block> past(const ChainArm& arm, int k, const Frame<Block>& at, const Block& q) {
    return beyond(arm.slides[k] ? Frame<Block>{at.R, at.p + q * at.R.z} : turned(at, cos_sin_of_any(q)), arm.step[k + 1]);
}

// Calls each(k, frame of joint k before it moves) for every joint of joint vectors, one from each lane's own place. Returns the
// frame of the tip. N: the number of joints, where it is known.
template <int N = 0, class Each>
STEP Frame<Block> walk(const ChainArm& arm, const double* const (&from)[BLOCK], const Each& each) {
    Frame<Block> at = constant_frame<Block>(arm.step[0]);
    if constexpr (N > 0) {
        Block q[N];
        load_rows(from, q);
        in_turn<0, N>([&](auto k) IN_PLACE { each(k, at), at = past(arm, k, at, q[k]); });
    } else {
        for (int k = 0; k < arm.joints; ++k) {
            Block q;
            for (int i = 0; i < BLOCK; ++i) q.set(i, from[i][k]);
            each(k, at), at = past(arm, k, at, q);
        }
    }
    return at;
}

// The same for `many` consecutive joint vectors; the last one fills the lanes that are left.
template <int N = 0, class Each> STEP Frame<Block> walk(const ChainArm& arm, const double* Q, int many, const Each& each) {
    const double* from[BLOCK];
    for (int i = 0; i < BLOCK; ++i) from[i] = Q + arm.joints * (i < many ? i : many - 1);
    return walk<N>(arm, from, each);
}

}  // namespace urdf_ik::URDF_IK_LEVEL
