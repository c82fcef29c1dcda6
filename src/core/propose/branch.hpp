// One branch of a closed form, on numbers, blocks or balls.
#pragma once

#include "arm/subproblems.hpp"
#include "arm/target.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A branch: the ideal arm's joint angles as (cos, sin), offsets included; the margins of shoulder, elbow and wrist, whose roots
// have the branch's signs (bits 4, 2 and 1 of its number); and the smallest squared lever arm of its angles (dimensionless).
// Margins and lever arms are reduced by the earlier joints' (see after).
template <class V> struct Branch {
    Turn<V> turn[6];
    V shoulder, elbow, wrist, arms;
    V lever[3];  // the smallest squared lever arms of shoulder, elbow and wrist, not reduced
};
// Joints that a pose leaves free, whose squared lever arms are at most `below`, take these values, offsets included.
struct FreeJoints {
    Turn<double> turn[6];
    double below;
};
// The signs of a block of branches; of closed forms with a quartic, its root.
template <class V> struct Signs {
    V shoulder, elbow, wrist;
    Turn<V> root = {};
    const FreeJoints* free = nullptr;
};
// A joint's turn with a squared lever arm, unless the pose leaves it free. A ball of such a turn is the whole circle.
template <class V> STEP Turn<V> unless_free(const Signs<V>& signs, const V& arm, const Turn<V>& turn, const Turn<double>& free) {
    if constexpr (requires { arm.rad; }) return turn;
    else {
        if (!signs.free) return turn;
        const auto loose = arm <= V(signs.free->below);
        return {select(loose, V(free.c), turn.c), select(loose, V(free.s), turn.s)};
    }
}
template <class V> STEP Turn<V> unless_free(const Signs<V>& signs, int joint, const V& arm, const Turn<V>& turn) {
    return unless_free(signs, arm, turn, signs.free ? signs.free->turn[joint] : Turn<double>{});
}
// wrist_turns() with this first turn where the pose leaves it free.
template <class V>
STEP WristTurns<V> wrist_turns(const Rot<V>& M, const Turn<V>& bend, const Twists& t, const Signs<V>& signs,
                               const Turn<double>& free) {
    const WristTurns<V> turns = wrist_turns(M, bend, t);
    if (!signs.free) return turns;
    return wrist_turns(M, bend, t, true, unless_free(signs, turns.fixed, turns.first, free));
}
template <class V>
STEP WristTurns<V> wrist_turns(const Rot<V>& M, const Turn<V>& bend, const Twists& t, const Signs<V>& signs, int first) {
    return wrist_turns(M, bend, t, signs, signs.free ? signs.free->turn[first] : Turn<double>{});
}
// The squared lever arm of a joint, reduced by those of earlier joints. A small motion of the target moves a joint by the motion
// over its lever arm, or over the root of its margin, and this moves all later joints: `before` is the smallest of these squares.
template <class V> STEP V after(const V& arm, const V& before) { return arm * min(V(1.0), before); }

// A family's branches, one per lane, as a call: the same code wherever numbers are wanted.
template <class Family>
PART void branch_of_lanes(const typename Family::Arm& arm, const Seen<Block>& seen, const Signs<Block>& signs, Branch<Block>& to) {
    to = Family::template branch<Block>(arm, seen, signs);
}

// Whether rounding may have changed the sign of one of the margins that a closed form computes one after the other.
//
// A step whose inputs err by e gives a margin m that errs by at most g e, and angles that err by at most g e / sqrt(m a): the
// root's error is that of the margin over the root, and a turn's error that of the vector over its length, the root of the squared
// lever arm a. So margin k errs by at most e g1 ... gk / sqrt(m1 a1 ... mk-1 ak-1), e being the targets' rounding. Its sign is
// right if mk^2 m1 a1 ... mk-1 ak-1 exceeds (e g1 g2 g3)^2, which is IdealFrames::together.
template <class V> struct Clear {
    V least, before;  // of mk^2 m1 a1 ... mk-1 ak-1; m1 a1 ... of the steps so far

    // The first step. A pose's first margin has no error from earlier steps: the fast path's edge exceeds its own.
    static STEP Clear first(const V& margin, const V& arm) { return {V(1.0), abs(margin) * arm}; }
    STEP Clear then(const V& margin, const V& arm) const {
        return {min(least, before * (margin * margin)), before * abs(margin) * arm};
    }
    STEP auto is_close(const V& last, double together) const { return min(least, before * (last * last)) <= V(together); }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
