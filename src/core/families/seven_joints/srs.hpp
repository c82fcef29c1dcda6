// All solutions of an S-R-S arm at a swivel angle, which swivel.hpp defines.
//
// The target fixes W, and with it the elbow's bend: |W - S| depends on joint 4 alone (law of cosines). The upper arm
// can still turn about the line SW, by the swivel angle. Upper arm and forearm then have known rotations, and each
// triple of meeting axes makes its own in two ways (Shimizu et al. 2008; subproblems: subproblems.hpp). Columns: 4
// shoulder + 2 elbow + wrist.
#pragma once

#include "families/blocks.hpp"
#include "families/seven_joints/swivel.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

STEP Twists twists_of(const MeetingAxes& axes) { return {axes.cos_alpha, axes.sin_alpha, axes.cos_beta, axes.sin_beta}; }

// The rotations that the two triples have to make: the shoulder in frame 1, the wrist in frame 5.
template <class V> STEP Rot<V> shoulder_rotation(const SrsArm& arm, const UpperArm<V>& elbow) { return elbow.R * arm.to_frame_3; }
template <class V> STEP Turn<V> fourth_turn(const SrsArm& arm, const UpperArm<V>& elbow) {
    Turn<V> t = elbow.bend;
    unturn(t.c, t.s, exact_turn(arm.zero_4));
    return t;
}
template <class V> STEP Rot<V> wrist_rotation(const SrsArm& arm, const UpperArm<V>& elbow, const Turn<V>& t4, const Rot<V>& R) {
    return each(R, [&](const Vec<V>& v) {
        Vec<V> e = {dot(elbow.R.x, v), dot(elbow.R.y, v), dot(elbow.R.z, v)};
        unturn(e.x, e.y, t4);
        return times(arm.from_frame_5, e);
    });
}

// Both solutions for three meeting axes that make a rotation: joint angles, the margin (negative if there is no
// solution), the smallest quantity that makes a pose doubtful, and the squared error.
template <class V> struct BothWays {
    V q[2][3], margin, doubt, error;
};
template <class V> STEP BothWays<V> both_ways(const MeetingAxes& axes, const Rot<V>& M) {
    const Twists t = twists_of(axes);
    const Bend<V> bend = wrist_bend<V>(M.z, t, 1.0);
    const WristTurns<V> turns = wrist_turns(M, bend.turn, t);
    const V middle = angle(bend.turn), first = wrap(angle(turns.first)), last = wrap(angle(turns.last));
    BothWays<V> out = {{{first, wrap(middle - axes.shift), last}, {}}, bend.margin, min(bend.margin, turns.fixed), turns.error};
    out.q[1][1] = wrap(-middle - axes.shift);
    if (axes.square) {
        out.q[1][0] = wrap(half_turn_from(first)), out.q[1][2] = wrap(half_turn_from(last));
    } else {
        const WristTurns<V> flipped = wrist_turns(M, Turn<V>{bend.turn.c, -bend.turn.s}, t);
        out.q[1][0] = wrap(angle(flipped.first)), out.q[1][2] = wrap(angle(flipped.last));
        out.error = max(out.error, flipped.error);
    }
    return out;
}

struct Srs {
    using Arm = SrsArm;
    static constexpr int branches = 8;
    static constexpr bool redundant = true;

    template <class Answers>
    static STEP void fast(const Arm& arm, const Seen<Block>& seen, const Block& value, Answers& found) {
        const Tolerances& tol = arm.written.tolerances;
        const double scale = 1.0 / (arm.written.size * arm.written.size), reach = 1e-2 * tol.reach * tol.reach;
        const Line<Block> line = line_to_wrist(seen.p);
        const Swivelled<Block> at = swivelled(line, cos_sin_of_any(value));
        const Block square = seen.p.x * seen.p.x + seen.p.y * seen.p.y;
        const auto on_axis = square <= tol.edge * (square + seen.p.z * seen.p.z);
        Block bend = 0.0;
        for (int down = 0; down < 2; ++down) {
            const double up = down ? -1.0 : 1.0;
            const UpperArm<Block> elbow = upper_arm<Block>(arm, line, at, up);
            if (!down) bend = angle(elbow.bend);
            const BothWays<Block> shoulder = both_ways(arm.shoulder, shoulder_rotation(arm, elbow));
            const BothWays<Block> wrist = both_ways(arm.wrist, wrist_rotation(arm, elbow, fourth_turn(arm, elbow), seen.R));
            const Block q4 = wrap(up * bend - arm.zero_4);
            const auto lost = min(min(elbow.margin, shoulder.margin), wrist.margin) < Block(-tol.edge);
            const auto doubt = (min(min(elbow.margin, shoulder.doubt), wrist.doubt) <= Block(tol.edge)) | on_axis |
                               !(elbow.error * scale + shoulder.error + wrist.error <= Block(reach));
            const Clear<Block> clear =
                Clear<Block>::first(square, 1.0 / (square + seen.p.z * seen.p.z)).then(elbow.margin, elbow.reach * scale);
            found.unproven |= bits(clear.is_close(min(abs(shoulder.margin), abs(wrist.margin)), arm.together));
            for (int k = 0; k < 4; ++k) {
                const auto &s = shoulder.q[k >> 1], &w = wrist.q[k & 1];
                found.set(4 * (k >> 1) + 2 * down + (k & 1), {s[0], s[1], s[2], q4, w[0], w[1], w[2]}, lost, doubt);
            }
        }
    }

    // A margin within rounding of zero is a double root, and one of its branches is
    // kept. If the target determines only the sum or difference of two joints, they take the reference's values, or
    // zero.
    static PART void closely(const Arm& arm, const Goal<double>& goal, const Seen<double>& seen, double value,
                             const Reference<7>& reference, const Columns<7>& columns, unsigned wanted) {
        const Tolerances& tol = arm.written.tolerances;
        const double scale = 1.0 / (arm.written.size * arm.written.size), singular = max(tol.singular * tol.singular, tol.fold);
        const Line<double> line = line_to_wrist(seen.p);
        const Swivelled<double> at = swivelled(line, cos_sin_of_any(value));
        const double square = seen.p.x * seen.p.x + seen.p.y * seen.p.y;
        const int aside = square <= tol.singular * tol.singular * (square + seen.p.z * seen.p.z) ? SHOULDER : 0;
        const double links = 2.0 * arm.upper * arm.fore * scale;
        for (int down = 0; down < 2; ++down) {
            if (!(wanted & (down ? 0xccu : 0x33u))) continue;
            const double up = down ? -1.0 : 1.0;
            UpperArm<double> elbow = upper_arm(arm, line, at, up);
            if (elbow.margin < -arm.clamp) continue;
            const bool free = elbow.margin <= singular || elbow.reach * scale <= tol.singular * tol.singular;
            if (is_double(elbow.margin, max(elbow.reach, 0.0) * scale, ROUNDING / links)) {
                if (down) continue;
                elbow = upper_arm(arm, line, at, 0.0);
            }
            triples_closely({arm, goal, seen, at_swivel(arm, at), reference, columns}, elbow, 2 * down, aside | (free ? ELBOW : 0));
        }
    }

    // See srs_boxes.hpp.
    static Status status(const Arm& arm, const Goal<double>& goal, const Seen<double>& seen, double value,
                         const Columns<7>& columns);

    // One pose at one swivel angle, and the columns for its solutions.
    struct Task {
        const Arm& arm;
        const Goal<double>& goal;
        const Seen<double>& seen;
        AtSwivel model;
        const Reference<7>& reference;
        const Columns<7>& columns;
    };

    static PART void triples_closely(const Task& task, const UpperArm<double>& elbow, int b, int marks) {
        const Arm& arm = task.arm;
        const Turn<double> t4 = fourth_turn(arm, elbow);
        const Rot<double> above = shoulder_rotation(arm, elbow), behind = wrist_rotation(arm, elbow, t4, task.seen.R);
        double q[7];
        q[3] = wrap(angle(t4));
        for (int shoulder = 0; shoulder < 2; ++shoulder) {
            const int first = turned_closely(task, arm.shoulder, above, shoulder, 0, q);
            for (int wrist = 0; first != IMPOSSIBLE && wrist < 2; ++wrist) {
                const int second = turned_closely(task, arm.wrist, behind, wrist, 4, q);
                if (second == IMPOSSIBLE) continue;
                double x[7];
                for (int j = 0; j < 7; ++j) x[j] = q[j];
                const double error = polish_one<true>(task.model, task.goal, x, {15, CONVERGED, LONG_PATIENCE}).error;
                if (!(error <= task.model.tolerances.reach) || !is_new(task.model, task.goal, task.columns, x)) continue;
                keep(task.columns, b + 4 * shoulder + wrist, x, marks | (first ? SHOULDER : 0) | (second ? WRIST : 0));
            }
        }
    }

    static constexpr int IMPOSSIBLE = -1;

    // One of the two solutions for three meeting axes that make the rotation M, written to q[at] and the two joints
    // after it. Returns IMPOSSIBLE if the solution does not exist or equals the other one, 1 near a singularity, else
    // 0.
    static PART int turned_closely(const Task& task, const MeetingAxes& axes, const Rot<double>& M, int flip, int at,
                                   double (&q)[7]) {
        const Tolerances& tol = task.arm.written.tolerances;
        const Twists t = twists_of(axes);
        Bend<double> bend = wrist_bend(M.z, t, flip ? -1.0 : 1.0);
        if (bend.margin < -task.arm.clamp) return IMPOSSIBLE;
        WristTurns<double> turns = wrist_turns(M, bend.turn, t);
        const bool once = is_double(bend.margin, turns.fixed, ROUNDING / (t.sb * t.sb));
        if (flip && (once || turns.fixed <= tol.continuum)) return IMPOSSIBLE;
        const int marked = min(bend.margin, turns.fixed) <= max(tol.singular * tol.singular, tol.fold);
        if (once) {
            bend = wrist_bend(M.z, t, 0.0);
            turns = wrist_turns(M, bend.turn, t);
        }
        if (turns.fixed <= tol.continuum) {
            turns = shared_turns(M, bend.turn, t, task.reference.q[at], task.reference.q[at + 2], task.reference.given);
        }
        q[at] = wrap(angle(turns.first)), q[at + 1] = wrap(angle(bend.turn) - axes.shift), q[at + 2] = wrap(angle(turns.last));
        return marked;
    }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
