// All solutions of six revolute joints whose axes 1, 2 and 3 are parallel.
//
// Joints 1 to 3 move the wrist across the parallel direction h and turn it about h by psi. The wrist's height along h
// and its tilt against h do not change. The target gives h in the frame of joint 6: the angle from h to axis 5 and the
// height of axis 6 along h are two equations in joints 4 and 6. Joint 5 and psi then follow directly, and a planar
// two-link arm gives joints 1 to 3. If two neighbouring axes of the wrist meet or are parallel, the two equations are
// solved one after the other; otherwise they lead to a quartic in joint 6. Source: Elias and Wen 2022 (three parallel
// axes, subproblem 6). Columns: 4 front/back + 2 up/down + noflip/flip.
#pragma once

#include "arm/linked_angles.hpp"
#include "arm/subproblems.hpp"
#include "families/blocks.hpp"
#include "families/closed_forms/parallel_shoulder_arm.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A row vector times Rz(t) Rx(alpha): a vector of one frame, seen from the next.
template <class V> STEP Vec<V> through_joint(Vec<V> v, const Turn<V>& t, double ca, double sa) {
    unturn(v.x, v.y, t), unturn(v.y, v.z, Turn<double>{ca, sa});
    return v;
}
// A vector of frame 6, in frame 5 after its joint has turned.
template <class V> STEP Vec<V> seen_from_5(const IdealFrames& arm, Vec<V> v, const Turn<V>& t6) {
    unturn(v.x, v.y, Turn<V>{t6.c, -t6.s}), unturn(v.y, v.z, Turn<double>{arm.cos_alpha[4], -arm.sin_alpha[4]});
    return v;
}

// The parallel direction in frame 6, and the height of the last axis above axis 4's foot along axis 3 [m].
template <class V> struct Height {
    Vec<V> h;
    V level;
};
STEP double same_sense(const IdealFrames& arm) { return arm.cos_alpha[0] * arm.cos_alpha[1]; }  // of axes 1 and 3: 1 or -1
template <class V> STEP Height<V> height_of(const IdealFrames& arm, const Seen<V>& at) {
    const double sense = same_sense(arm);
    return {{sense * at.R.x.z, sense * at.R.y.z, sense * at.R.z.z}, sense * at.p.z - arm.d[1] - arm.cos_alpha[2] * arm.d[2]};
}

// Joints 4 and 6, and the margins of their two roots.
template <class V> struct WristEnds {
    Turn<V> t4, t6;
    V first, second;
};

// With u the angle between axis 5 and h: cos u = ca3 ca4 - sa3 sa4 cos t4 = ca5 h_z + sa5 (h_x sin t6 + h_y cos t6) and
// level = a4 sa3 sin t4 + d5 cos u + a5 (h_x cos t6 - h_y sin t6). root: the quartic's, which only a general wrist uses.
template <LastAxes kind, class V>
STEP WristEnds<V> wrist_ends(const IdealFrames& arm, const Height<V>& at, const V& front, const V& flip, const Turn<V>& root) {
    const double a4 = arm.a[3], a5 = arm.a[4], d5 = arm.d[3], ca3 = arm.cos_alpha[2], sa3 = arm.sin_alpha[2];
    const double ca4 = arm.cos_alpha[3], sa4 = arm.sin_alpha[3], ca5 = arm.cos_alpha[4], sa5 = arm.sin_alpha[4];
    const Vec<V>& h = at.h;
    const Twists back = {ca4, sa4, ca3, sa3};
    if constexpr (kind == LastAxes::intersecting_56) {
        const Swing<V> s = swing_to_offset<V>(-a4, -d5 * sa4, (at.level - d5 * ca3 * ca4) * (1.0 / sa3), front);
        const Vec<V> w = through_joint<V>({V(0.0), V(sa3), V(ca3)}, s.turn, ca4, sa4);
        const Bend<V> b = swing_to_tilt<V>(h, ca5, sa5, w.z, w.x * w.x + w.y * w.y, flip);
        return {s.turn, b.turn, s.margin * (1.0 / (a4 * a4 + d5 * d5 * sa4 * sa4)), b.margin};
    } else if constexpr (kind == LastAxes::parallel_56) {
        const Bend<V> b = wrist_bend<V>({h.x, h.y, ca5 * h.z}, back, front);
        const Swing<V> s = swing_to_offset<V>(h.y, h.x, (at.level - a4 * sa3 * b.turn.s) * (1.0 / a5), flip);
        return {b.turn, s.turn, b.margin, s.margin};
    } else if constexpr (kind == LastAxes::intersecting_45) {
        const V x = a5 * h.y - d5 * sa5 * h.x, y = d5 * sa5 * h.y + a5 * h.x;
        const Swing<V> s = swing_to_offset<V>(x, y, at.level - d5 * ca5 * h.z, front);
        const Bend<V> b = wrist_bend<V>(seen_from_5(arm, h, s.turn), back, flip);
        return {b.turn, s.turn, s.margin * (1.0 / (a5 * a5 + d5 * d5 * sa5 * sa5)), b.margin};
    } else if constexpr (kind == LastAxes::parallel_45) {
        const Bend<V> b = swing_to_tilt<V>(h, ca5, sa5, ca3 * ca4, sa3 * sa3, front);
        const Vec<V> v = seen_from_5(arm, h, b.turn);
        const V s4 = (at.level - d5 * v.z - a5 * v.x) * (1.0 / (a4 * sa3)), margin = (1.0 - s4) * (1.0 + s4);
        return {unit(flip * margin_root(margin), s4), b.turn, b.margin, margin};
    } else {
        const Vec<V> v = seen_from_5(arm, h, root);
        const V c4 = (ca3 * ca4 - v.z) * (1.0 / (sa3 * sa4)), s4 = (at.level - d5 * v.z - a5 * v.x) * (1.0 / (a4 * sa3));
        return {unit(c4, s4), root, V(1.0), V(1.0)};
    }
}

// Angles of joint 6 of a general wrist, sharpened where axis 5 is almost parallel to axes 1 to 3.
PART Quartic last_angles(const IdealFrames& arm, const Height<double>& at, const Slack& off) {
    const double a4 = arm.a[3], a5 = arm.a[4], d5 = arm.d[3], ca3 = arm.cos_alpha[2], sa3 = arm.sin_alpha[2];
    const double ca4 = arm.cos_alpha[3], sa4 = arm.sin_alpha[3], ca5 = arm.cos_alpha[4], sa5 = arm.sin_alpha[4];
    const double w = -1.0 / (sa3 * sa4), v = 1.0 / (a4 * sa3);
    const Vec<double>& h = at.h;
    const Affine<double> cosine = {(ca5 * h.z - ca3 * ca4) * w, sa5 * h.y * w, sa5 * h.x * w};
    const Affine<double> sine = {(at.level - d5 * ca5 * h.z) * v, -(d5 * sa5 * h.y + a5 * h.x) * v,
                                 -(d5 * sa5 * h.x - a5 * h.y) * v};
    const double slack = 2.0 * off.shift + 2.0 * (abs(d5) + abs(a5)) * off.turn;
    Quartic roots = linked_roots(cosine, sine, 2.0 * abs(w) * off.turn, slack * abs(v));
    for (int k = 0; k < 2; ++k) {
        const double side = k ? -1.0 : 1.0;
        const Turn<double> e = unit(side * h.y, side * h.x);
        const Bend<double> b = wrist_bend<double>(seen_from_5(arm, h, e), {ca4, sa4, ca3, sa3}, 1.0);
        sharpen_roots({e, b.turn.c, b.margin, -(cosine.cosine * e.c + cosine.sine * e.s)}, sine, roots);
    }
    return roots;
}

// Joint 5 from the direction of h, seen through joint 4 and seen through joint 6.
template <class V> struct MiddleTurn {
    Turn<V> t5;
    V arm5, sense;  // squared sine between axis 5 and h; its cosine
    V error;        // squared, of the equations of wrist_ends
};
template <class V> STEP MiddleTurn<V> middle_turn(const IdealFrames& arm, const Height<V>& at, const Turn<V>& t4,
                                                  const Turn<V>& t6) {
    const double sa3 = arm.sin_alpha[2], ca3 = arm.cos_alpha[2];
    const Vec<V> w = through_joint<V>({V(0.0), V(sa3), V(ca3)}, t4, arm.cos_alpha[3], arm.sin_alpha[3]),
                 v = seen_from_5(arm, at.h, t6);
    const V arm5 = w.x * w.x + w.y * w.y, tilt = w.z - v.z;
    const V high = (at.level - arm.a[3] * sa3 * t4.s - arm.d[3] * v.z - arm.a[4] * v.x) * (1.0 / arm.size);
    return {unit(w.x * v.x + w.y * v.y, w.y * v.x - w.x * v.y), arm5, v.z, tilt * tilt / (arm5 + TINY) + high * high};
}

// Axes x and y of frame 3 seen from frame 5 before and after joint 5 turns.
template <class V> struct HandAxes {
    Vec<V> x, y;
};
template <class V> STEP HandAxes<V> hand_at(const IdealFrames& arm, const Turn<V>& t4) {
    const double ca4 = arm.cos_alpha[3], sa4 = arm.sin_alpha[3], sense = same_sense(arm);
    return {through_joint<V>({V(1.0), V(0.0), V(0.0)}, t4, ca4, sa4),
            through_joint<V>({V(0.0), V(sense * arm.cos_alpha[2]), V(-sense * arm.sin_alpha[2])}, t4, ca4, sa4)};
}

// The turn psi about the parallel axes by joints 1 to 3 together, from all components of the rotation.
template <class V> STEP Turn<V> turn_of_hand(const IdealFrames& arm, const Rot<V>& R, const HandAxes<V>& hand, const Turn<V>& t5,
                                             const Turn<V>& t6) {
    Vec<V> x = through_joint(hand.x, t5, arm.cos_alpha[4], arm.sin_alpha[4]),
           y = through_joint(hand.y, t5, arm.cos_alpha[4], arm.sin_alpha[4]);
    unturn(x.x, x.y, t6), unturn(y.x, y.y, t6);
    const Vec<V> row0 = {R.x.x, R.y.x, R.z.x}, row1 = {R.x.y, R.y.y, R.z.y};
    return unit(dot(row0, x) + dot(row1, y), dot(row1, x) - dot(row0, y));
}

// From axis 3 to the origin of frame 5, across the parallel axes, before the turn psi [m].
template <class V> STEP Plane<V> hand_across(const IdealFrames& arm, const Turn<V>& t4) {
    const double ca4 = arm.cos_alpha[3], sa4 = arm.sin_alpha[3], a4 = arm.a[3], d5 = arm.d[3];
    const V x = a4 * t4.c + d5 * sa4 * t4.s, y = a4 * t4.s - d5 * sa4 * t4.c;
    return {arm.a[2] + x, same_sense(arm) * (arm.cos_alpha[2] * y - arm.sin_alpha[2] * (arm.d[2] + d5 * ca4))};
}
// The same to the origin of frame 6.
template <class V> STEP Plane<V> last_across(const IdealFrames& arm, const Turn<V>& t4, const HandAxes<V>& hand,
                                             const Turn<V>& t5) {
    const Plane<V> f = hand_across(arm, t4);
    return {f.x + arm.a[4] * (t5.c * hand.x.x + t5.s * hand.x.y), f.y + arm.a[4] * (t5.c * hand.y.x + t5.s * hand.y.y)};
}

template <LastAxes kind> struct ParallelShoulder {
    using Arm = ParallelShoulderArm;
    static constexpr int branches = 8;
    static constexpr bool by_signs = kind != LastAxes::general;
    static constexpr int flags[3] = {WRIST, ELBOW, WRIST};  // of the singularities of its margins
    static constexpr unsigned root_bit = 1, root_joint = 5;  // see proposals.hpp

    template <class V> static STEP Branch<V> branch(const Arm& arm, const Seen<V>& seen, const Signs<V>& signs) {
        const auto& ideal = arm.ideal;
        const double scale = 1.0 / (ideal.size * ideal.size), side = ideal.cos_alpha[0];
        const Height<V> at = height_of(ideal, seen);
        const V arm6 = at.h.x * at.h.x + at.h.y * at.h.y;
        const WristEnds<V> ends = wrist_ends<kind, V>(ideal, at, signs.shoulder, signs.wrist, signs.root);
        const Turn<V> t6 = unless_free(signs, 5, arm6, ends.t6);
        const MiddleTurn<V> middle = middle_turn(ideal, at, ends.t4, t6);
        const Turn<V> t5 = unless_free(signs, 4, middle.arm5, middle.t5);
        const HandAxes<V> hand = hand_at(ideal, ends.t4);
        const Turn<V> psi = turn_of_hand(ideal, seen.R, hand, t5, t6);
        const Plane<V> u = rest_across(seen.p, last_across(ideal, ends.t4, hand, t5), psi);
        const Elbow<V> e = elbow(u.x, u.y, ideal.a[0], ideal.a[1], side, signs.elbow);
        const V arm1 = (u.x * u.x + u.y * u.y) * scale, ahead = min(abs(ends.first), abs(ends.second));
        const V lever = min(middle.arm5, arm6);
        const V held = min(after(middle.arm5, ahead), arm6);
        const Turn<V> t1 = unless_free(signs, 0, arm1, e.second), t2 = unit(e.bend.c, e.bend.s);
        Turn<V> t3 = psi;
        unturn(t3.c, t3.s, t1), unturn(t3.c, t3.s, Turn<V>{t2.c, side * t2.s});
        return {{t1, t2, unit(t3.c, same_sense(ideal) * t3.s), ends.t4, t5, t6},
                ends.first,
                e.margin,
                ends.second,
                min(held, after(arm1, min(ahead, min(middle.arm5, arm6)))),
                {kind == LastAxes::intersecting_56 ? V(1.0) : lever, arm1, lever}};
    }

    static Quartic quartic(const Arm& arm, const Seen<double>& seen) {
        return last_angles(arm.ideal, height_of(arm.ideal, seen), slack_of(arm.ideal, seen));
    }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
