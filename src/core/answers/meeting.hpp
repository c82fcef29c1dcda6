// The careful path of three neighbouring joints whose axes meet, in a closed form whose other joints are known: a wrist, at the end
// of an arm or in its middle.
#pragma once

#include "answers/around.hpp"
#include "kinematics/subproblems.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The other joints of a branch: their angles, offsets included; how accurate they are; the flags of their singularities; whether
// one is near a singularity; whether rounding leaves open that they exist.
struct Others {
    Turn<double> turn[6];
    Drift drift;
    int marks;
    bool near, unsure;
};

// The branch b of the joints from `first` on, which make the rotation M. flag: of their singularity. rooted: a quartic precedes
// them, whose roots are inaccurate where it is ill-conditioned: Newton's method decides. A margin within `fold` of zero is a double
// root, and one of its branches is kept. If the target determines only the sum or difference of two joints, they take the
// reference's values. Returns whether rounding leaves the branch in doubt.
template <class Arm>
PART bool meeting_closely(const Arm& arm, const Goal<double>& goal, const Rot<double>& M, const Others& at, int first, int flag,
                          bool rooted, const Reference<6>& reference, int b, const Columns<6>& columns) {
    const auto& ideal = arm.ideal;
    const Tolerances& tol = arm.written.tolerances;
    const Twists t = {ideal.cos_alpha[first], ideal.sin_alpha[first], ideal.cos_alpha[first + 1], ideal.sin_alpha[first + 1]};
    const double flip = ideal.signs[2][b];
    Bend<double> bend = wrist_bend(M.z, t, flip);
    if (bend.margin < -max(max(ideal.clamp, rooted ? HALF_OF_THE_DIGITS : 0.0), at.drift.of_margin()))
        return at.drift.hides(bend.margin);
    WristTurns<double> turns = wrist_turns(M, bend.turn, t);
    Drift drift = at.drift;
    drift.through_arm(turns.fixed);
    const bool free = turns.fixed <= tol.continuum, loose = !free && at.drift.frees(turns.fixed);
    const bool unsure = loose || at.drift.hides(bend.margin) || (!free && at.drift.by > 0.0 && drift.is_lost());
    const int marks = at.marks | (min(turns.fixed, bend.margin) <= marked(tol, reference) ? flag : 0);
    const bool twice = is_double(bend.margin, turns.fixed, ROUNDING / (t.sb * t.sb));
    if (flip < 0.0 && (twice || free)) return unsure;
    if (twice) {
        bend.turn = wrist_bend(M.z, t, 0.0).turn;
        turns = wrist_turns(M, bend.turn, t);
    }
    const bool near = at.near || abs(bend.margin) < NEAR || turns.fixed < NEAR;
    const bool sure = reference.displaced == 0.0 && !at.unsure && !unsure && bend.margin >= -ideal.clamp;
    const auto candidate = [&](const WristTurns<double>& ends, double (&q)[6]) {
        Turn<double> found[6];
        for (int j = 0; j < 6; ++j) found[j] = at.turn[j];
        found[first] = ends.first, found[first + 1] = bend.turn, found[first + 2] = ends.last;
        for (int j = 0; j < 6; ++j) q[j] = wrap(angle(found[j]) - ideal.offset[j]);
    };
    const auto shared = [&] {
        return shared_turns(M, bend.turn, t, reference.q[first] + ideal.offset[first],
                            reference.q[first + 2] + ideal.offset[first + 2], reference.given);
    };
    double q[6];
    candidate(free ? shared() : turns, q);
    if (rooted || sure || !arm.written.exact || holds(arm.written, goal, q, reference.displaced > 0.0 ? PATIENCE : LONG_PATIENCE)) {
        accept(arm.written, goal, q, b, marks, near, columns);
    }
    if (loose && !columns.valid(b) && !columns.valid(b & ~1)) {
        candidate(shared(), q);
        keep_unless_represented(arm.written, goal, q, b, marks, columns);
    }
    return unsure;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
