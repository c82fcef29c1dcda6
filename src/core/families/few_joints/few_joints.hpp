// Arms with one to five joints, turning or sliding: a position step, then the remaining turns, verified on the arm as written.
//
// An arm of so few joints reaches few poses, so its Jacobian is a tall matrix and Newton's method solves least squares.
// The target gives the position of every point of the tip. Three joints place a point that the last turns do not move
// (slide_position.hpp), and these turns follow from the rotation.
#pragma once

#include "answers/candidates.hpp"
#include "families/few_joints/slide_position.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

STEP Goal<double> inverse(const Goal<double>& g) {
    const Rot<double>& R = g.R;
    return {{{R.x.x, R.y.x, R.z.x}, {R.x.y, R.y.y, R.z.y}, {R.x.z, R.y.z, R.z.z}},
            {-dot(R.x, g.p), -dot(R.y, g.p), -dot(R.z, g.p)}};
}
// The rotation from the tip's home to R.
STEP Rot<double> from_home(const Rot<double>& R, const double (&home)[3][3]) {
    return {R * vec<double>(home[0]), R * vec<double>(home[1]), R * vec<double>(home[2])};
}
// The rotation R with the turning joints of the step undone.
STEP Rot<double> behind(const PositionStep& step, const double (&q)[3], Rot<double> R) {
    for (int k = 0; k < 3; ++k) {
        if (!step.slides[k]) R = turned_about(R, vec<double>(step.direction[k]), cos_sin(-q[k]));
    }
    return R;
}
// The target position of a point of the tip; both as shares of the size.
STEP Vec<double> place_of(const Goal<double>& goal, const double (&in_tip)[3], double size) {
    return goal.R * vec<double>(in_tip) + (1.0 / size) * goal.p;
}

// A candidate: the arm's joint vector for values of the step's three joints.
template <int N>
STEP void gather(const FewJointsArm<N>& arm, const FewJointsWay& way, const Goal<double>& seen, const double (&placed)[3],
                 double (&q)[N]) {
    double turn[5] = {placed[0], placed[1], placed[2], 0.0, 0.0};
    if (way.turns) {
        Rot<double> rest = behind(way.step, placed, from_home(seen.R, way.home));
        for (int k = 0; k < way.turns; ++k) {
            const Vec<double> h = vec<double>(way.axis[k]);
            // Of the last one any direction across it: the greater one of two that are never both short.
            const Vec<double> mark = k + 1 < way.turns ? vec<double>(way.axis[k + 1])
                                     : abs(h.z) > 0.8  ? Vec<double>{0.0, h.z, -h.y}
                                                       : Vec<double>{h.y, -h.x, 0.0};
            turn[3 + k] = turn_about(h, mark, rest * mark).angle;
            rest = turned_about(rest, h, cos_sin(-turn[3 + k]));
        }
    }
    for (int k = 0; k < 5; ++k) {
        if (way.joint[k] >= 0) q[way.joint[k]] = k < 3 && way.step.slides[k] ? turn[k] * arm.written.size : wrap(turn[k]);
    }
}

// Candidates of one way. Returns whether a joint was nearly free.
template <int N>
PART bool go(const FewJointsArm<N>& arm, const FewJointsWay& way, const Goal<double>& goal, const Reference<N>& reference,
             const Columns<N>& columns) {
    const Goal<double> seen = way.reversed ? inverse(goal) : goal;
    const double size = arm.written.size;
    double ref[3] = {}, q[N] = {};
    for (int k = 0; k < 3; ++k) {
        if (way.joint[k] >= 0) ref[k] = way.step.slides[k] ? reference.q[way.joint[k]] / size : reference.q[way.joint[k]];
    }
    bool doubt = false;
    PositionSolver solver(way.step, place_of(seen, way.in_tip, size), ref);
    const Places& places = solver.solve();
    for (int c = 0; c < places.count; ++c) {
        const PlaceTried& place = places.at[c];
        gather(arm, way, seen, place.q, q);
        const Origin origin = place.free ? Origin::doubtful : Origin::computed;
        const double sigma = polish_and_keep(arm.written, goal, q, origin, arm.written.tolerances.reach, columns);
        if (!place.free || sigma <= arm.written.tolerances.singular) continue;
        doubt = true;
        for (int k = 0; k < 2; ++k) {
            for (int a = 0; a < (place.free >> k & 1 ? 2 * AROUND : 0); ++a) {
                double around[3] = {place.q[0], place.q[1], place.q[2]};
                around[k] = wrap(PI * a / AROUND);
                gather(arm, way, seen, around, q);
                polish_and_keep(arm.written, goal, q, Origin::searched, CONVERGED, columns);
            }
        }
    }
    return doubt;
}

template <int N, int B> struct FewJoints {
    using Arm = FewJointsArm<N>;
    static constexpr int branches = B;

    static STEP void solve(const Arm& arm, const Goal<double>& goal, const Reference<N>& reference, const Columns<N>& columns) {
        for (int k = 0; k < arm.ways && go(arm, arm.way[k], goal, reference, columns); ++k) {}
        sort(columns);
    }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
