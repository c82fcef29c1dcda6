// The first three joints of an arm with a spherical wrist bring its centre to a point, for every kind of shoulder.
//
// p = Rz(t1) [a1 x + Rx(alpha1) u] with u = Rz(t2) f and f = d2 z + a2 x + Rx(alpha2) (d3 z + Rz(t3) g), where g is the
// wrist centre in frame 3. Sources: Pieper 1968; Craig, Introduction to Robotics, section 4.6; Elias and Wen 2022.
#pragma once

#include "families/closed_forms/spherical_wrist_arm.hpp"
#include "propose/branch.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The three angles; margins of shoulder and elbow (dimensionless); squared lever arms of joints 1 and 2, and the
// squared error of the position [shares of size^2].
template <class V> struct Place {
    Turn<V> t1, t2, t3;
    V margin1, margin2, arm1, arm2, error;
};

// The point f for a third angle.
template <class V> STEP Vec<V> second_link(const SphericalWristArm& arm, const Turn<V>& t3) {
    const auto& ideal = arm.ideal;
    const double ca2 = ideal.cos_alpha[1], sa2 = ideal.sin_alpha[1], w2 = arm.centre[2] + ideal.d[1];
    const V w0 = arm.centre[0] * t3.c - arm.centre[1] * t3.s, w1 = arm.centre[0] * t3.s + arm.centre[1] * t3.c;
    return {ideal.a[1] + w0, ca2 * w1 - sa2 * w2, ideal.d[0] + sa2 * w1 + ca2 * w2};
}

// Squared distance between the wrist centre at these angles and its target [share of size^2].
template <class V> STEP V position_error(const SphericalWristArm& arm, const Vec<V>& p, const Place<V>& at, const Vec<V>& f) {
    const double ca1 = arm.ideal.cos_alpha[0], sa1 = arm.ideal.sin_alpha[0], scale = 1.0 / (arm.ideal.size * arm.ideal.size);
    const V gx = arm.ideal.a[0] + at.t2.c * f.x - at.t2.s * f.y, gy = at.t2.s * f.x + at.t2.c * f.y;
    const V hy = ca1 * gy - sa1 * f.z, hz = sa1 * gy + ca1 * f.z;
    const V ex = at.t1.c * gx - at.t1.s * hy - p.x, ey = at.t1.s * gx + at.t1.c * hy - p.y, ez = hz - p.z;
    return (ex * ex + ey * ey + ez * ez) * scale;
}

// Axes 2 and 3 parallel: joint 1 by the plane in which the arm lies, then a planar arm of two links.
template <class V> struct Front {
    Turn<V> t1;
    V ux, uy, margin;
};
template <class V> STEP Front<V> face(const SphericalWristArm& arm, const Vec<V>& p, const V& front) {
    const double ca1 = arm.ideal.cos_alpha[0], sa1 = arm.ideal.sin_alpha[0], h = arm.height;
    const double scale = 1.0 / (arm.ideal.size * arm.ideal.size);
    const V uy = (p.z - ca1 * h) * (1.0 / sa1);
    const Swing<V> s = swing_to_offset(p.x, p.y, ca1 * uy - sa1 * h, front);
    return {s.turn, s.X - arm.ideal.a[0], uy, s.margin * scale};
}
template <class V>
STEP Place<V> bend_elbow(const SphericalWristArm& arm, const Vec<V>& p, const Front<V>& at, const Signs<V>& signs) {
    const double scale = 1.0 / (arm.ideal.size * arm.ideal.size);
    const Elbow<V> e = elbow(at.ux, at.uy, arm.ideal.a[1], arm.rho, arm.ideal.cos_alpha[1], signs.elbow);
    Place<V> out;
    out.t3 = {e.bend.c * arm.cos_phi + e.bend.s * arm.sin_phi, e.bend.s * arm.cos_phi - e.bend.c * arm.sin_phi};
    out.margin1 = at.margin, out.margin2 = e.margin;
    out.arm1 = (p.x * p.x + p.y * p.y) * scale, out.arm2 = (at.ux * at.ux + at.uy * at.uy) * scale;
    out.t1 = unless_free(signs, 0, out.arm1, at.t1), out.t2 = unless_free(signs, 1, out.arm2, e.second);
    out.error = position_error(arm, p, out, second_link(arm, out.t3));
    return out;
}

// The other shoulders: joint 3 first.
template <Shoulder kind, class V> struct Third {
    Turn<V> t3;
    Vec<V> f;
    V margin;
};
template <Shoulder kind, class V> STEP Third<kind, V> third(const SphericalWristArm& arm, const Vec<V>& p, const V& up) {
    if constexpr (kind == Shoulder::intersecting_12) {
        const V c = dot(p, p) * arm.swing[0] + arm.swing[1], margin = (1.0 - c) * (1.0 + c);
        const V k = min(max(c, -1.0), 1.0), s = up * margin_root(margin);
        const Turn<V> t3 = {k * arm.cos_phi - s * arm.sin_phi, s * arm.cos_phi + k * arm.sin_phi};
        return {t3, second_link(arm, t3), margin};
    } else {
        const V s = arm.ideal.cos_alpha[0] * p.z * arm.swing[0] + arm.swing[1], margin = (1.0 - s) * (1.0 + s);
        const V k = min(max(s, -1.0), 1.0), c = up * margin_root(margin);
        const Turn<V> t3 = {c * arm.cos_phi + k * arm.sin_phi, k * arm.cos_phi - c * arm.sin_phi};
        return {t3, second_link(arm, t3), margin};
    }
}

// Joints 1 and 2 for a given joint 3.
template <Shoulder kind, class V>
STEP Place<V> first_two(const SphericalWristArm& arm, const Vec<V>& p, const Third<kind, V>& at, const Signs<V>& signs) {
    const double a1 = arm.ideal.a[0], ca1 = arm.ideal.cos_alpha[0], sa1 = arm.ideal.sin_alpha[0];
    const double scale = 1.0 / (arm.ideal.size * arm.ideal.size);
    const Vec<V>& f = at.f;
    const V arm2 = f.x * f.x + f.y * f.y;
    Place<V> out;
    V ux, uy;
    if constexpr (kind == Shoulder::parallel_12) {
        // With a shorter side of the triangle joint 2 is free.
        const V length = max(root(arm2), V(VANISHING * arm.ideal.size));
        const Elbow<V> e = elbow(p.x, p.y, V(a1), length, ca1, signs.shoulder);
        out.t1 = e.second, out.margin1 = e.margin, ux = length * e.bend.c, uy = length * e.bend.s;
    } else {
        uy = (p.z - ca1 * f.z) * (1.0 / sa1);
        if constexpr (kind == Shoulder::intersecting_12) {
            out.margin1 = (arm2 - uy * uy) * scale;
            ux = signs.shoulder * margin_root(arm2 - uy * uy);
        } else {
            out.margin1 = 1.0;
            ux = (dot(p, p) - a1 * a1 - arm2 - f.z * f.z) * (0.5 / a1);
        }
        const V X = a1 + ux, Y = ca1 * uy - sa1 * f.z;
        out.t1 = unit(X * p.x + Y * p.y, X * p.y - Y * p.x);
    }
    out.t3 = at.t3, out.margin2 = at.margin;
    out.arm1 = (p.x * p.x + p.y * p.y) * scale, out.arm2 = arm2 * scale;
    out.t1 = unless_free(signs, 0, out.arm1, out.t1);
    out.t2 = unless_free(signs, 1, out.arm2, unit(f.x * ux + f.y * uy, f.x * uy - f.y * ux));
    out.error = position_error(arm, p, out, f);
    return out;
}

// One of the solutions, by the signs of shoulder and elbow; of a general shoulder by its root.
template <Shoulder kind, class V> STEP Place<V> position(const SphericalWristArm& arm, const Vec<V>& p, const Signs<V>& signs) {
    if constexpr (kind == Shoulder::parallel_23) return bend_elbow(arm, p, face(arm, p, signs.shoulder), signs);
    else if constexpr (kind == Shoulder::general)
        return first_two<kind, V>(arm, p, {signs.root, second_link(arm, signs.root), 1.0}, signs);
    else return first_two<kind>(arm, p, third<kind>(arm, p, signs.elbow), signs);
}

}  // namespace urdf_ik::URDF_IK_LEVEL
