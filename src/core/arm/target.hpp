// From target poses to the solver's own frames.
#pragma once

#include "arm/arm.hpp"
#include "numbers/vectors.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A target for the ideal arm: the rotation of frame 6 and the solved point, both in frame 1.
template <class V> using Seen = Frame<V>;

// The distance of sixteen numbers from a rigid motion: the largest entry of R^T R - I and of the last row's error. Infinite or NaN
// for a reflection, a NaN, an infinity or a position beyond LARGEST.
template <class V> STEP V pose_defect(const V (&t)[16]) {
    const Vec<V> x = {t[0], t[4], t[8]}, y = {t[1], t[5], t[9]}, z = {t[2], t[6], t[10]};
    const V last = t[15] - 1.0, xx = abs(dot(x, x) - 1.0), yy = abs(dot(y, y) - 1.0), zz = abs(dot(z, z) - 1.0);
    const V row = max(max(abs(t[12]), abs(t[13])), max(abs(t[14]), abs(last)));
    const V across = max(max(abs(dot(x, y)), abs(dot(x, z))), abs(dot(y, z)));
    const V worst = max(max(max(xx, yy), max(zz, across)), row);
    // Products with zero carry a NaN or an infinity on, where max() would drop it.
    const V lost = 0.0 * (xx + yy + zz + (t[12] + t[13] + t[14] + last)) + (0.0 * t[3] + 0.0 * t[7] + 0.0 * t[11]);
    const V far = max(max(abs(t[3]), abs(t[7])), abs(t[11]));
    const V near = select(V(LARGEST) < far, V(__builtin_inf()), worst);
    return select(dot(cross(x, y), z) > V(0.0), near, V(__builtin_inf())) + lost;
}

template <class V> STEP Seen<V> to_frame_1(const Frame<V>& target, const Ends& arm) {
    const double *l = arm.tool_point, *o = arm.base_origin;
    const Rot<V>& R = target.R;
    const Vec<V> p = combine(R, l[0], l[1], l[2]) + Vec<V>{target.p.x - o[0], target.p.y - o[1], target.p.z - o[2]};
    const Rot<V> S = each(R, [&](const Vec<V>& v) { return times(arm.base_rotation, v); });
    return {S * arm.tool_rotation, times(arm.base_rotation, p)};
}
// t: the sixteen numbers of a pose, row by row.
template <class V> STEP Seen<V> to_frame_1(const V (&t)[16], const Ends& arm) {
    return to_frame_1<V>({{{t[0], t[4], t[8]}, {t[1], t[5], t[9]}, {t[2], t[6], t[10]}}, {t[3], t[7], t[11]}}, arm);
}

// What separates the exact target of an exact arm's closed form from the one in use [rad, m]: rounding, and that of the arm's
// numbers.
struct Slack {
    double turn, shift;
};
STEP Slack slack_of(const IdealFrames& arm, const Seen<double>& seen) {
    const double far = arm.size + sqrt(dot(seen.p, seen.p));
    return {arm.displacement.turn[0] + ROUNDING, arm.displacement.shift[0] + ROUNDING * far};
}

// T with its rotation replaced by the nearest one: Newton's iteration for the polar factor (Higham 1986).
PART void project_rotation(const double* T, double (&out)[16]) {
    for (int i = 0; i < 16; ++i) out[i] = T[i];
    for (int round = 0; round < 6; ++round) {
        const Vec<double> x = {out[0], out[4], out[8]}, y = {out[1], out[5], out[9]}, z = {out[2], out[6], out[10]};
        // The transposed inverse is the matrix of cofactors over the determinant.
        const Vec<double> yz = cross(y, z), zx = cross(z, x), xy = cross(x, y);
        const double w = 0.5 / dot(x, yz);
        const Vec<double> a = 0.5 * x + w * yz, b = 0.5 * y + w * zx, c = 0.5 * z + w * xy;
        out[0] = a.x, out[4] = a.y, out[8] = a.z, out[1] = b.x, out[5] = b.y, out[9] = b.z;
        out[2] = c.x, out[6] = c.y, out[10] = c.z;
        if (abs(a.x - x.x) + abs(b.y - y.y) + abs(c.z - z.z) < 1e-16) break;
    }
}

}  // namespace urdf_ik::URDF_IK_LEVEL
