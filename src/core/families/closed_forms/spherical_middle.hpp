// All solutions of six revolute joints whose axes 2, 3 and 4 meet in a point C.
//
// Seen from the base, only joint 1 moves C; seen from the tip, only joints 5 and 6 do. So C lies on a circle about axis
// 1 and on a torus about axes 5 and 6. Its height along axis 6 and its squared distance from the origin of frame 6 give
// two equations, each affine in (cos, sin) of joint 1 and of joint 5. If axes 5 and 6 meet (the torus is a sphere) or
// are parallel (a plane), one equation holds joint 1 alone; otherwise they lead to a quartic in joint 1. Joint 6 then
// follows directly, and joints 2 to 4 make the remaining rotation like a wrist. Source: Pieper 1968, whose decoupling
// works wherever in the arm the three axes are. Columns: 4 front/back + 2 up/down + noflip/flip; of the quartic 2 root
// + noflip/flip.
#pragma once

#include "arm/linked_angles.hpp"
#include "arm/subproblems.hpp"
#include "families/blocks.hpp"
#include "families/closed_forms/spherical_middle_arm.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// By joint 1: height of C along axis 6 above the origin of frame 6 [m], and its squared distance from there [m^2].
template <class V> STEP Affine<V> height_of_centre(const SphericalMiddleArm& arm, const Seen<V>& at) {
    const double x = arm.centre[0], y = arm.centre[1], z = arm.centre[2];
    const Vec<V>& a = at.R.z;
    return {a.z * (z - at.p.z) - a.x * at.p.x - a.y * at.p.y, a.x * x + a.y * y, a.y * x - a.x * y};
}
template <class V> STEP Affine<V> square_of_centre(const SphericalMiddleArm& arm, const Vec<V>& p) {
    const double x = arm.centre[0], y = arm.centre[1];
    const V up = arm.centre[2] - p.z;
    return {x * x + y * y + p.x * p.x + p.y * p.y + up * up, -2.0 * (p.x * x + p.y * y), -2.0 * (p.y * x - p.x * y)};
}
STEP double reach_of_5(const SphericalMiddleArm& arm) {
    return sqrt(arm.centre_5[0] * arm.centre_5[0] + arm.centre_5[1] * arm.centre_5[1]);
}

// Joint 1 where one equation holds it alone; margin and squared arm are dimensionless.
template <class V> struct FirstTurn {
    Turn<V> t1;
    V margin, arm1;
};
template <LastPair kind, class V> STEP FirstTurn<V> first_turn(const SphericalMiddleArm& arm, const Seen<V>& at, const V& front) {
    const double *g = arm.centre_5, radius = arm.centre[0] * arm.centre[0] + arm.centre[1] * arm.centre[1];
    if constexpr (kind == LastPair::intersecting) {
        const Affine<V> a = square_of_centre(arm, at.p);
        const V c = 0.5 * a.cosine, s = 0.5 * a.sine, k = 0.5 * (g[0] * g[0] + g[1] * g[1] + g[2] * g[2] - a.constant);
        const Swing<V> swing = swing_to_offset<V>(-s, c, k, front);
        const double w = 1.0 / (radius * arm.ideal.size * arm.ideal.size);
        return {swing.turn, swing.margin * w, (c * c + s * s) * w};
    } else {
        const Affine<V> a = height_of_centre(arm, at);
        const Swing<V> swing = swing_to_offset<V>(-a.sine, a.cosine, arm.ideal.cos_alpha[4] * g[2] - a.constant, front);
        return {swing.turn, swing.margin * (1.0 / radius), (a.cosine * a.cosine + a.sine * a.sine) * (1.0 / radius)};
    }
}

// C in frame 6 for a given joint 1 [m].
template <class V> STEP Vec<V> centre_seen_from_6(const SphericalMiddleArm& arm, const Seen<V>& at, const Turn<V>& t1) {
    const double x = arm.centre[0], y = arm.centre[1];
    const Vec<V> d = Vec<V>{t1.c * x - t1.s * y, t1.c * y + t1.s * x, V(arm.centre[2])} - at.p;
    return {dot(at.R.x, d), dot(at.R.y, d), dot(at.R.z, d)};
}

// Joints 5 and 6 that have C at u of frame 6; margin [share of the squared radius]; squared error [m^2].
template <class V> struct LastTurns {
    Turn<V> t5, t6;
    V margin, error;
};
// C is f = Rz(-t5) g in frame 5, and e = Rx(-alpha5) (f - a5 x) in frame 6 before joint 6 turns.
template <LastPair kind, class V> STEP LastTurns<V> last_turns(const SphericalMiddleArm& arm, const Vec<V>& u, const V& up) {
    const double gx = arm.centre_5[0], gy = arm.centre_5[1], gz = arm.centre_5[2];
    const double a5 = arm.ideal.a[4], ca5 = arm.ideal.cos_alpha[4], sa5 = arm.ideal.sin_alpha[4], square = gx * gx + gy * gy;
    const V rr = u.x * u.x + u.y * u.y;
    V fx, fy, ex, ey, margin = 1.0;
    if constexpr (kind == LastPair::parallel) {
        const double r = reach_of_5(arm), w = 0.5 / (a5 * r), inner = a5 - r, outer = a5 + r;
        const V near = (rr - inner * inner) * w, far = (outer * outer - rr) * w;
        margin = near * far;
        fx = 0.5 * r * (far - near), fy = up * (r * margin_root(margin));
        ex = ((r - a5) * (r + a5) - rr) * (0.5 / a5), ey = ca5 * fy;
    } else {
        fy = (ca5 * gz - u.z) * (1.0 / sa5), ey = ca5 * fy + sa5 * gz;
        if constexpr (kind == LastPair::intersecting) {
            margin = (rr - ey * ey) * (1.0 / square);
            fx = ex = up * margin_root(margin * square);
        } else {
            ex = (square + gz * gz - a5 * a5 - rr - u.z * u.z) * (0.5 / a5), fx = ex + a5;
        }
    }
    const Turn<V> t5 = unit(gx * fx + gy * fy, gy * fx - gx * fy), t6 = unit(ex * u.x + ey * u.y, ey * u.x - ex * u.y);
    Vec<V> e = {t5.c * gx + t5.s * gy - a5, t5.c * gy - t5.s * gx, V(gz)};
    unturn(e.y, e.z, Turn<double>{ca5, sa5}), unturn(e.x, e.y, t6);
    const Vec<V> off = e - u;
    return {t5, t6, margin, dot(off, off)};
}

// A rotation of the last frames, turned back by a joint and the twist before it.
template <class V> STEP Rot<V> turned_back(const Rot<V>& R, const Turn<V>& t, double ca, double sa) {
    const Vec<V> x = t.c * R.x - t.s * R.y, y = t.c * R.y + t.s * R.x;
    return {x, V(ca) * y - V(sa) * R.z, V(ca) * R.z + V(sa) * y};
}
// The rotation that joints 2 to 4 have to make, in the frame before joint 2 turns.
template <class V>
STEP Rot<V> middle_rotation(const IdealFrames& arm, const Rot<V>& R, const Turn<V>& t1, const Turn<V>& t5, const Turn<V>& t6) {
    const Rot<V> M = turned_back(turned_back(R, t6, arm.cos_alpha[4], arm.sin_alpha[4]), t5, arm.cos_alpha[3], arm.sin_alpha[3]);
    return each(M, [&](Vec<V> v) {
        unturn(v.x, v.y, t1), unturn(v.y, v.z, Turn<double>{arm.cos_alpha[0], arm.sin_alpha[0]});
        return v;
    });
}

template <LastPair kind> struct SphericalMiddle {
    using Arm = SphericalMiddleArm;
    static constexpr int branches = 8;
    static constexpr bool by_signs = kind != LastPair::general;
    static constexpr int flags[3] = {SHOULDER, WRIST, ELBOW};  // of the singularities of its margins
    static constexpr unsigned root_bit = 2, root_joint = 0;  // see proposals.hpp

    static STEP Twists twists(const Arm& arm) {
        return {arm.ideal.cos_alpha[1], arm.ideal.sin_alpha[1], arm.ideal.cos_alpha[2], arm.ideal.sin_alpha[2]};
    }

    template <class V> static STEP Branch<V> branch(const Arm& arm, const Seen<V>& seen, const Signs<V>& signs) {
        const auto& ideal = arm.ideal;
        const Twists t = twists(arm);
        FirstTurn<V> first = {signs.root, V(1.0), V(1.0)};
        if constexpr (by_signs) first = first_turn<kind, V>(arm, seen, signs.shoulder);
        first.t1 = unless_free(signs, 0, first.arm1, first.t1);
        const Vec<V> u = centre_seen_from_6(arm, seen, first.t1);
        const V arm6 = (u.x * u.x + u.y * u.y) * (1.0 / (ideal.size * ideal.size));
        LastTurns<V> last = last_turns<kind, V>(arm, u, signs.elbow);
        last.t6 = unless_free(signs, 5, arm6, last.t6);
        const Rot<V> M = middle_rotation(ideal, seen.R, first.t1, last.t5, last.t6);
        const Bend<V> bend = wrist_bend(M.z, t, signs.wrist);
        const WristTurns<V> turns = wrist_turns(M, bend.turn, t, signs, 1);
        const V outer = min(min(abs(first.margin), first.arm1), min(abs(last.margin), arm6));
        return {{first.t1, turns.first, bend.turn, unit(turns.last.c, turns.last.s), last.t5, last.t6},
                first.margin,
                last.margin,
                bend.margin,
                min(min(first.arm1, arm6), after(turns.fixed, outer)),
                {first.arm1, arm6, turns.fixed}};
    }

    // Angles of joint 1 if axes 5 and 6 are skew.
    static PART Quartic quartic(const Arm& arm, const Seen<double>& seen) {
        const double gz = arm.centre_5[2], a5 = arm.ideal.a[4], r = reach_of_5(arm);
        Affine<double> square = square_of_centre(arm, seen.p), height = height_of_centre(arm, seen);
        const Slack off = slack_of(arm.ideal, seen);
        const double far = arm.ideal.size + sqrt(dot(seen.p, seen.p)), w = 1.0 / abs(a5 * r),
                     v = 1.0 / abs(arm.ideal.sin_alpha[4] * r);
        square.constant -= r * r + gz * gz + a5 * a5, height.constant -= arm.ideal.cos_alpha[4] * gz;
        return linked_roots(scaled(square, -0.5 / (a5 * r)), scaled(height, -1.0 / (arm.ideal.sin_alpha[4] * r)),
                            2.0 * w * far * off.shift, 2.0 * v * (off.shift + far * off.turn));
    }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
