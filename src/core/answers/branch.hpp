// One branch of a closed form, on numbers, blocks or balls.
#pragma once

#include "kinematics/subproblems.hpp"
#include "kinematics/target.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A branch: the ideal arm's joint angles as (cos, sin), offsets included; the margins of shoulder, elbow and wrist, whose roots
// have the branch's signs (bits 4, 2 and 1 of its number); and the smallest squared lever arm of its angles (dimensionless).
// Margins and lever arms are reduced by the earlier joints' (see after).
template <class V> struct Branch {
    Turn<V> turn[6];
    V shoulder, elbow, wrist, arms;
};
// The signs of a block of branches; of closed forms with a quartic, its root.
template <class V> struct Signs {
    V shoulder, elbow, wrist;
    Turn<V> root = {};
};
// The squared lever arm of a joint, reduced by those of earlier joints. A small motion of the target moves a joint by the motion
// over its lever arm, or over the root of its margin, and this moves all later joints: `before` is the smallest of these squares.
template <class V> STEP V after(const V& arm, const V& before) { return arm * min(V(1.0), before); }

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
