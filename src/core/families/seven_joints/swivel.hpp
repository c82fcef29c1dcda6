// The swivel angle of an S-R-S arm: axes 1, 2, 3 meet in S, axes 5, 6, 7 in W, axis 4 between.
//
// The swivel angle turns about the line SW. It leads from the normal of the plane that holds S, W and axis 1 to axis
// 4's direction, less its part along the line. If W lies on axis 1, to HALF_OF_THE_DIGITS, there is no such plane, and frame 1's
// x, made perpendicular to the line, replaces the normal. Unlike the elbow's position, the direction of axis 4 defines
// the angle for a stretched arm too. Source: Shimizu, Kakuya, Yoon, Kitagaki and Kosuge 2008, there for axes at right
// angles.
#pragma once

#include "arm/subproblems.hpp"
#include "arm/target.hpp"
#include "families/seven_joints/srs_arm.hpp"
#include "propose/polish.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// From S to W in frame 1: unit direction, normal of its plane with axis 1, their vector product, length [m].
template <class V> struct Line {
    Vec<V> along, normal, across;
    V length;
};
template <class V> STEP Line<V> line_to_wrist(const Vec<V>& p) {
    const V square = p.x * p.x + p.y * p.y, length = sqrt(square + p.z * p.z), aside = sqrt(square);
    Vec<V> d = V(1.0 / (length + TINY)) * p;
    const auto on = aside <= HALF_OF_THE_DIGITS * length;
    const V v = 1.0 / (aside + TINY);
    // Frame 1's x, made perpendicular to the line.
    const V u = 1.0 / sqrt(1.0 - d.x * d.x + TINY);
    const Vec<V> n = {select(on, (1.0 - d.x * d.x) * u, -p.y * v), select(on, -d.x * d.y * u, p.x * v),
                      select(on, -d.x * d.z * u, V(0.0))};
    // If W coincides with S there is no line: axis 1 replaces it.
    d.z = select(length > V(0.0), d.z, 1.0);
    return {d, n, cross(d, n), length};
}

// ahead: the normal turned by the swivel angle, the direction of axis 4 less its part along the line. level: the
// direction perpendicular to `ahead` and the line.
template <class V> struct Swivelled {
    Vec<V> ahead, level;
};
template <class V> STEP Swivelled<V> swivelled(const Line<V>& line, const Turn<V>& swivel) {
    return {swivel.c * line.normal + swivel.s * line.across, swivel.c * line.across - swivel.s * line.normal};
}

// The elbow's bend, and its frame in frame 1; the bend's margin sin^2, the squared distance of the parallel to axis 4
// through S from W [m^2], and the squared error of W's place [m^2].
template <class V> struct UpperArm {
    Turn<V> bend;
    Rot<V> R;
    V margin, reach, error;
};
// up: the sign of the bend. longer: a factor for the distance of W, for starts beside a stretched or folded arm.
template <class V>
STEP UpperArm<V> upper_arm(const SrsArm& arm, const Line<V>& line, const Swivelled<V>& at, const V& up, double longer = 1.0) {
    const double a = arm.upper, b = arm.fore, c = arm.along;
    const V length = line.length * longer, reach = length * length - c * c, across = sqrt(max(reach, V(0.0)));
    const Elbow<V> e = elbow(across, V(0.0), a, b, -1.0, up);
    // If W lies on the parallel to axis 4 through S, any direction is right.
    const Turn<V> first = unit(e.second.c + select(across > V(0.0), V(0.0), 1.0), e.second.s);
    const V w = 1.0 / (sqrt(across * across + c * c) + TINY), kappa = c * w, leaning = across * w;
    const V rho = select(leaning + abs(kappa) > V(0.0), leaning, 1.0);
    const Vec<V> m = rho * line.along - kappa * at.ahead;
    UpperArm<V> out;
    out.bend = e.bend;
    out.R = {first.c * m + first.s * at.level, first.s * m - first.c * at.level, kappa * line.along + rho * at.ahead};
    out.margin = select(reach >= V(-ROUNDING * c * c), e.margin, -1.0);
    out.reach = reach;
    const Vec<V> off = combine(out.R, 1.0, 0.0, 0.0);
    const Vec<V> gap = V(a + b * e.bend.c) * off + V(b * e.bend.s) * out.R.y + V(c) * out.R.z - length * line.along;
    out.error = dot(gap, gap);
    return out;
}

// The model of an S-R-S arm at one swivel angle for Newton's method: the arm as written, and a seventh equation. The
// target fixes the line SW, and with it the direction `level` (in the base) to which axis 4 is perpendicular.
struct AtSwivel {
    static constexpr int joints = 7, rows = 7;
    const Written<7>& arm;
    const Tolerances& tolerances;
    Vec<double> ahead, level;
};
STEP AtSwivel at_swivel(const SrsArm& arm, const Swivelled<double>& at) {
    const auto& R = arm.ideal.base_rotation;
    const auto back = [&](const Vec<double>& v) {
        return v.x * vec<double>(R[0]) + v.y * vec<double>(R[1]) + v.z * vec<double>(R[2]);
    };
    return {arm.written, arm.written.tolerances, back(at.ahead), back(at.level)};
}

template <class V> STEP Error<V, 7> swivel_error(const AtSwivel& model, const Goal<V>& goal, const Posture<7, V>& at) {
    const Error<V> pose = pose_error(goal, at.tip, 1.0 / model.arm.size);
    const Vec<V>& axis = at.joint[3].R.z;
    const V off = -dot(spread<V>(model.level), axis);
    Error<V, 7> e;
    for (int i = 0; i < 6; ++i) e.twist[i] = pose.twist[i];
    e.twist[6] = off;
    // The opposite direction is half a turn away.
    e.size = select(dot(spread<V>(model.ahead), axis) > V(0.0), max(pose.size, abs(off)), 2.0);
    return e;
}
template <class V> STEP Error<V, 7> error_at(const AtSwivel& model, const Goal<V>& goal, const V (&q)[7]) {
    return swivel_error(model, goal, place(model.arm, q));
}
template <class V>
STEP Error<V, 7> error_and_jacobian(const AtSwivel& model, const Goal<V>& goal, const V (&q)[7], Rows<7, V> (&J)[7]) {
    const Posture<7, V> at = place(model.arm, q);
    const Vec<V> turned = cross(at.joint[3].R.z, spread<V>(model.level));
    for (int k = 0; k < 7; ++k) {
        const Six<V> column = jacobian_column(at.joint[k], false, at.tip.p, 1.0 / model.arm.size);
        for (int i = 0; i < 6; ++i) J[k][i] = column[i];
        J[k][6] = k < 3 ? dot(at.joint[k].R.z, turned) : V(0.0);
    }
    return swivel_error(model, goal, at);
}
template <class V> STEP V advanced(const AtSwivel&, int, const V& q, const V& x) { return wrap(q + x); }
STEP double gap(const AtSwivel&, int, double a, double b) { return wrap(a - b); }

}  // namespace urdf_ik::URDF_IK_LEVEL
