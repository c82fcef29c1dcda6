// One branch of a closed form, on numbers, blocks or balls.
#pragma once

#include "kinematics/target.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A branch: the ideal arm's joint angles as (cos, sin), offsets included; the margins of shoulder, elbow and wrist, whose roots
// have the branch's signs (bits 4, 2 and 1 of its number); and the smallest squared lever arm of its angles (dimensionless).
// Margins and lever arms are reduced by the earlier joints' (see after).
template <class V> struct Branch {
    Turn<V> turn[6];
    V shoulder, elbow, wrist, arms;
};
// The signs of a block of branches.
template <class V> struct Signs {
    V shoulder, elbow, wrist;
};
// The squared lever arm of a joint, reduced by those of earlier joints. A small motion of the target moves a joint by the motion
// over its lever arm, or over the root of its margin, and this moves all later joints: `before` is the smallest of these squares.
template <class V> STEP V after(const V& arm, const V& before) { return arm * min(V(1.0), before); }

}  // namespace urdf_ik::URDF_IK_LEVEL
