// See curves.hpp.
#include "self_motion/follower.hpp"

namespace urdf_ik {

void interpolate(const FreeArm& arm, const CurveSample& a, const CurveSample& b, double share, double* q, double* along) {
    const double u = share;
    for (int j = 0; j < 7; ++j) {
        const double d = gap_of(arm, j, b.q[j], a.q[j]), s = b.arc * a.along[j], e = b.arc * b.along[j];
        const double third = s + e - 2.0 * d, second = 3.0 * d - 2.0 * s - e;
        q[j] = a.q[j] + arm.unit[j] * u * (s + u * (second + u * third));
        if (along) along[j] = s + u * (2.0 * second + 3.0 * u * third);
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
