// Arms with one to five joints, turning or sliding: a position step, then the remaining turns, verified on the arm as written.
//
// An arm of so few joints reaches few poses, so its Jacobian is a tall matrix and Newton's method solves least squares.
// The target gives the position of every point of the tip. Three joints place a point that the last turns do not move
// (slide_position.hpp), and these turns follow from the rotation.
#pragma once

#include "families/few_joints/slide_position.hpp"
#include "propose/candidates.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

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

// The values of a way's joints for values of the step's three; a length is a share of the size. off: bounds on the errors of the
// step's joints, and of all joints afterwards [rad, share of size].
PART void add_turns(const FewJointsWay& way, const Goal<double>& seen, double (&turn)[5], double (&off)[5]) {
    if (!way.turns) return;
    double turned = PLACE_ERROR;
    for (int k = 0; k < 3; ++k) turned += way.step.slides[k] ? 0.0 : off[k];
    Rot<double> rest = behind(way.step, {turn[0], turn[1], turn[2]}, from_home(seen.R, way.home));
    for (int k = 0; k < way.turns; ++k) {
        const Vec<double> h = vec<double>(way.axis[k]);
        // Of the last one any direction across it: the greater one of two that are never both short.
        const Vec<double> mark = k + 1 < way.turns ? vec<double>(way.axis[k + 1])
                                 : abs(h.z) > 0.8  ? Vec<double>{0.0, h.z, -h.y}
                                                   : Vec<double>{h.y, -h.x, 0.0};
        const TurnAbout t = turn_about(h, mark, rest * mark);
        turn[3 + k] = t.angle, off[3 + k] = turned / max(0.6 * sqrt(t.square), TINY), turned += off[3 + k];
        rest = turned_about(rest, h, cos_sin(-turn[3 + k]));
    }
}

// A candidate: the arm's joint vector for values of the step's three joints.
template <int N>
STEP void gather(const FewJointsArm<N>& arm, const FewJointsWay& way, const Goal<double>& seen, const double (&placed)[3],
                 double (&q)[N], double (&off)[5]) {
    double turn[5] = {placed[0], placed[1], placed[2], 0.0, 0.0};
    add_turns(way, seen, turn, off);
    for (int k = 0; k < 5; ++k) {
        if (way.joint[k] >= 0) q[way.joint[k]] = k < 3 && way.step.slides[k] ? turn[k] * arm.written.size : wrap(turn[k]);
    }
}

// The largest error that rounding, and the tolerance to which a solution is verified, leave of a pose.
inline constexpr double POSE_MISSED = 1e-9;

// Whether it is certain what a candidate stands for: for the one solution q, whose Jacobian's smallest singular value is at least
// sigma, or, where sigma is infinite, for none. off: bounds on the distances of a solution that it stands for, by joint. A joint
// that moves by x moves the pose by at most `lever` x, so the candidate itself misses the pose by no more than `lever` times the
// bounds. The second derivative of the pose is at most N (lever + 2) |d|^2, so a second solution is at least 2 sigma / (N (lever +
// 2)) away (seven_joints/srs_boxes.hpp).
template <int N>
STEP bool is_certain(const Written<N>& arm, const Goal<double>& goal, const double (&candidate)[N], const double (&off)[N],
                     const double (&q)[N], double sigma) {
    double lever = 1.0, square = 0.0, sum = 0.0;
    bool near = true;
    for (int j = 0; j < N; ++j) {
        const double* t = arm.step[j + 1].t;
        lever += sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]) / arm.size;
        near = near && abs(gap(arm, j, candidate[j], q[j])) <= off[j] + POSE_MISSED;
        square += off[j] * off[j], sum += off[j];
    }
    if (sigma < __builtin_inf()) return near && N * (lever + 2.0) * (sqrt(square) + POSE_MISSED) < sigma;
    return missed_by(arm, goal, candidate) > lever * sum + POSE_MISSED;
}

// A joint that the position leaves nearly free is tried at this many values around each half of the circle.
inline constexpr int AROUND = 12;
// Calls f with the values of the step's joints, one that the position leaves nearly free at these values.
template <class F> STEP void at_values_around(const PlaceTried& place, const F& f) {
    for (int k = 0; k < 2; ++k) {
        for (int a = 0; a < (place.free >> k & 1 ? 2 * AROUND : 0); ++a) {
            double around[3] = {place.q[0], place.q[1], place.q[2]};
            around[k] = wrap(PI * a / AROUND);
            f(around);
        }
    }
}

// What is known after a way has been gone: a joint was nearly free; the solutions are all.
struct Gone {
    bool doubt, proven;
};
// Candidates of one way.
template <int N>
PART Gone go(const FewJointsArm<N>& arm, const FewJointsWay& way, const Goal<double>& goal, const Reference<N>& reference,
             const Columns<N>& columns) {
    const Goal<double> seen = way.reversed ? inverse(goal) : goal;
    const double size = arm.written.size;
    double ref[3] = {}, q[N] = {};
    for (int k = 0; k < 3; ++k) {
        if (way.joint[k] >= 0) ref[k] = way.step.slides[k] ? reference.q[way.joint[k]] / size : reference.q[way.joint[k]];
    }
    Gone out = {false, false};
    PositionSolver solver(way.step, place_of(seen, way.in_tip, size), ref);
    const Places& places = solver.solve();
    out.proven = places.whole;
    for (int c = 0; c < places.count; ++c) {
        const PlaceTried& place = places.at[c];
        double off[5] = {place.off[0], place.off[1], place.off[2], 0.0, 0.0}, candidate[N];
        gather(arm, way, seen, place.q, q, off);
        double bounds[N] = {};
        for (int j = 0; j < N; ++j) candidate[j] = q[j];
        for (int k = 0; k < 5; ++k) {
            if (way.joint[k] >= 0) bounds[way.joint[k]] = off[k];
        }
        const Origin origin = place.free ? Origin::doubtful : Origin::computed;
        const double sigma = polish_and_keep(arm.written, goal, q, origin, arm.written.tolerances.reach, columns);
        out.proven = out.proven && is_certain(arm.written, goal, candidate, bounds, q, sigma);
        if (!place.free || sigma <= arm.written.tolerances.singular) continue;
        out.doubt = true;
        at_values_around(place, [&](const double (&around)[3]) {
            gather(arm, way, seen, around, q, off);
            polish_and_keep(arm.written, goal, q, Origin::searched, CONVERGED, columns);
        });
    }
    return out;
}

template <int N, int B> struct FewJoints {
    using Arm = FewJointsArm<N>;
    static constexpr int branches = B;

    // Returns the status, which belongs to the first column.
    static STEP Status find(const Arm& arm, const Goal<double>& goal, const Reference<N>& reference, const Columns<N>& columns) {
        bool proven = false;
        for (int k = 0; k < arm.ways; ++k) {
            const Gone gone = go(arm, arm.way[k], goal, reference, columns);
            proven = proven || gone.proven;
            if (!gone.doubt) break;
        }
        sort(columns);
        return proven ? Status::complete : Status::incomplete;
    }
    static STEP void solve(const Arm& arm, const Goal<double>& goal, const Reference<N>& reference, const Columns<N>& columns) {
        const Status status = find(arm, goal, reference, columns);
        set_status(columns.flags[0], status);
    }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
