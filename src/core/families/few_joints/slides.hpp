// Six joints with slides: three turning joints give the orientation, the other three the position.
//
// Spherical wrist: the first three joints, of any kind, place the point where the last three axes meet (slide_position.hpp), and
// the wrist gives the orientation. Three slides: they do not turn the tip, so the three turning joints follow from the
// orientation, wherever they are in the chain, and the slides from a linear system. Candidates are polished and verified.
#pragma once

#include <initializer_list>

#include "arm/subproblems.hpp"
#include "families/few_joints/few_joints.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// a' b
STEP Rot<double> seen_from(const Rot<double>& a, const Rot<double>& b) {
    return each(b, [&](const Vec<double>& v) { return Vec<double>{dot(a.x, v), dot(a.y, v), dot(a.z, v)}; });
}
STEP Rot<double> rotation(const double (&R)[3][3]) {
    return {{R[0][0], R[1][0], R[2][0]}, {R[0][1], R[1][1], R[2][1]}, {R[0][2], R[1][2], R[2][2]}};
}

// Writes the three turns that make the rotation E, measured from home, to their places in q. sign chooses the flip.
// Returns false beyond the reach of a wrist with oblique axes. If the target leaves the first turn free, only the
// positive sign returns true; the reference then decides how the first and the last turn share the rotation.
// off: bound on the error of E, replaced by one for the turns; sure: whether it leaves open that both flips are there, or none. As
// for together() in closed_forms.cpp a margin errs by at most 20 times the error over the squared sines of the twists.
PART bool turn_wrist(const SlidesArm& arm, const Rot<double>& E, double sign, const Reference<6>& reference, double (&q)[6],
                     double& off, bool& sure) {
    const Twists t = {arm.ca, arm.sa, arm.cb, arm.sb};
    const Rot<double> M = seen_from(rotation(arm.first), E * arm.last);
    const Bend<double> bend = wrist_bend(M.z, t, sign);
    const double error = 20.0 * off / (t.sa * t.sa * t.sb * t.sb);
    sure = sure && abs(bend.margin) > error + HALF_OF_THE_DIGITS;
    if (!(bend.margin >= -max(HALF_OF_THE_DIGITS, arm.clamp))) return false;
    WristTurns<double> turns = wrist_turns(M, bend.turn, t);
    off = error / sqrt(max(min(bend.margin, turns.fixed), TINY));
    if (turns.fixed <= arm.written.tolerances.continuum) {
        if (sign < 0.0) return false;
        turns = shared_turns(M, bend.turn, t, reference.q[arm.turn[0]], reference.q[arm.turn[2]], reference.given);
    }
    q[arm.turn[0]] = angle(turns.first), q[arm.turn[1]] = wrap(angle(bend.turn) - arm.bend), q[arm.turn[2]] = angle(turns.last);
    return true;
}

// The joint vector for values of the first three joints and one flip of the wrist. Returns whether it exists.
STEP bool wrist_behind(const SlidesArm& arm, const Goal<double>& goal, const double (&placed)[3], double sign,
                       const Reference<6>& reference, double (&q)[6], double& off, bool& sure) {
    for (int k = 0; k < 3; ++k) q[k] = arm.step.slides[k] ? placed[k] * arm.written.size : wrap(placed[k]);
    return turn_wrist(arm, behind(arm.step, placed, from_home(goal.R, arm.home)), sign, reference, q, off, sure);
}

// Solutions by the wrist's position, each with both flips. Returns whether they are proven to be all.
PART bool by_wrist(const SlidesArm& arm, const Goal<double>& goal, const Reference<6>& reference, const Columns<6>& columns) {
    const double size = arm.written.size;
    double ref[3], q[6];
    for (int k = 0; k < 3; ++k) ref[k] = arm.step.slides[k] ? reference.q[k] / size : reference.q[k];
    PositionSolver solver(arm.step, place_of(goal, arm.in_tip, size), ref);
    const Places& places = solver.solve();
    bool proven = places.whole && arm.imperfection == 0.0;
    for (int c = 0; c < places.count; ++c) {
        const PlaceTried& place = places.at[c];
        for (const double sign : {1.0, -1.0}) {
            double bounds[6] = {place.off[0], place.off[1], place.off[2]}, candidate[6], off = PLACE_ERROR;
            for (int k = 0; k < 3; ++k) off += arm.step.slides[k] ? 0.0 : place.off[k];
            if (!wrist_behind(arm, goal, place.q, sign, reference, q, off, proven)) continue;
            for (int k = 0; k < 3; ++k) bounds[arm.turn[k]] = off;
            for (int j = 0; j < 6; ++j) candidate[j] = q[j];
            const Origin origin = place.free || arm.imperfection > 0.0 ? Origin::doubtful : Origin::computed;
            const double sigma = polish_and_keep(arm.written, goal, q, origin, arm.written.tolerances.reach, columns);
            proven = proven && is_certain(arm.written, goal, candidate, bounds, q, sigma);
            if (!place.free || sigma <= arm.written.tolerances.singular) continue;
            at_values_around(place, [&](const double (&around)[3]) {
                bool sure = false;
                if (wrist_behind(arm, goal, around, sign, reference, q, off, sure))
                    polish_and_keep(arm.written, goal, q, Origin::searched, CONVERGED, columns);
            });
        }
    }
    return proven;
}

// Solutions of an arm with three slides: the turning joints from the orientation, the slides from a linear system.
// Returns whether they are proven to be all: the slides are where the turns put them.
PART bool by_slides(const SlidesArm& arm, const Goal<double>& goal, const Reference<6>& reference, const Columns<6>& columns) {
    bool proven = arm.imperfection == 0.0;
    for (const double sign : {1.0, -1.0}) {
        double q[6] = {}, off = PLACE_ERROR;
        if (!turn_wrist(arm, from_home(goal.R, arm.home), sign, reference, q, off, proven)) continue;
        const Posture<6, double> at = place(arm.written, q);
        const Vec<double> rest = goal.p - at.tip.p;
        Six<double> along[3];
        int k = 0;
        for (int j = 0; j < 6; ++j) {
            const Vec<double>& z = at.joint[j].R.z;
            if (arm.written.slides[j] && k < 3) along[k++] = {{z.x, z.y, z.z, 0.0, 0.0, 0.0}};
        }
        // If the slides lie in one plane, a singularity, take the shortest solution.
        const Solved<3, double> slid = least_squares<true>(along, {{rest.x, rest.y, rest.z, 0.0, 0.0, 0.0}}, CONVERGED);
        k = 0;
        for (int j = 0; j < 6; ++j) {
            if (arm.written.slides[j] && k < 3) q[j] = slid.x[k++];
        }
        const double sigma = polish_and_keep(arm.written, goal, q, Origin::doubtful, arm.written.tolerances.reach, columns);
        proven = proven && off < NEAR && sigma > NEAR && sigma < __builtin_inf();
    }
    return proven;
}

// Marks a singular solution as the wrist's if the axes of the three turns lie in a plane.
PART void name_singular(const SlidesArm& arm, const Columns<6>& columns) {
    for (int b = 0; b < columns.many; ++b) {
        if (!(columns.flags[b] & OTHER)) continue;
        const Posture<6, double> at = place(arm.written, columns.row(b));
        const auto z = [&](int k) { return at.joint[arm.turn[k]].R.z; };
        if (abs(dot(z(0), cross(z(1), z(2)))) <= arm.written.tolerances.singular) columns.flags[b] = VALID | WRIST;
    }
}

template <int B> struct Slides {
    using Arm = SlidesArm;
    static constexpr int branches = B;

    static STEP void solve(const Arm& arm, const Goal<double>& goal, const Reference<6>& reference, const Columns<6>& columns) {
        const bool proven = arm.by_wrist ? by_wrist(arm, goal, reference, columns) : by_slides(arm, goal, reference, columns);
        name_singular(arm, columns);
        sort(columns);
        if (!proven) set_status(columns.flags[0], Status::incomplete);
    }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
