// See curves.hpp.
#include "motion/self_motion/follower.hpp"

namespace urdf_ik {

void interpolate(const FreeArm& arm, const CurveSample& a, const CurveSample& b, double share, double* q, double* along) {
    for (int j = 0; j < 7; ++j) {
        const Cubic way = joint_on(arm, j, a, b);
        q[j] = a.q[j] + arm.unit[j] * way.at(share);
        if (along) along[j] = way.slope(share);
    }
}

void follow_curves(const FreeArm& arm, const SelfMotionFunctions& core, const GridOfSolutions& given, long pose, Intervals& to) {
    self_motion::Follower follower(arm, core, given);
    follower.follow();
    const std::vector<self_motion::Piece> pieces = follower.pieces();
    follower.cut(pieces, pose, to);
    for (const self_motion::Piece& piece : pieces) {
        const bool seen =
            std::any_of(piece.columns.begin(), piece.columns.end(), [](const auto& each) { return each.second >= 0; });
        if (!seen) to.unseen.push_back({pose, piece.samples[piece.samples.size() / 2].value});
    }
}

}  // namespace urdf_ik
