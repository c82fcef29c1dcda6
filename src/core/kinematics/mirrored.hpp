// Two solutions of a pose that differ in three neighbouring joints alone are mirror images of each other if the axes of these
// joints, a, b and c, meet in a point or are parallel: a wrist that flips, an elbow that is bent the other way. The axes a and c
// are then the same lines for both, since a is fixed to the link before the three joints and c to the link after them, which both
// stand still; and b is mirrored in the plane of a and c. So its screw becomes -b + alpha a + gamma c, where (alpha a + gamma c) /
// 2 is b's projection on that plane. The image has the Jacobian J M, where M is the identity but for b's column (alpha, -1, gamma),
// and the least-squares inverse M^-1 X: the rows
//   X_a + alpha X_b,  -X_b,  X_c + gamma X_b,
// and all others as they are. This also holds with a further row of J that does not depend on these joints, or only through the
// motion that they give to the link after them.
#pragma once

#include "kinematics/kinematics.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// alpha and gamma.
template <class V> struct Projection {
    V alpha, gamma;
};

// joint: the frames of joints a, b and c. Infinite or NaN where a and c are the same line, where the Jacobian is singular.
template <class V>
STEP Projection<V> projection(bool parallel, const Frame<V>& a, const Frame<V>& b, const Frame<V>& c) {
    const V ab = dot(a.R.z, b.R.z), bc = dot(b.R.z, c.R.z);
    if (parallel) {
        // Of the points where a plane across the axes meets them, and of axes that may point either way.
        const Vec<V> off = b.p - a.p, apart = c.p - a.p;
        const Vec<V> across = apart - dot(apart, b.R.z) * b.R.z;
        const V twice = 2.0 * dot(off, across) / dot(across, across);
        return {ab * (2.0 - twice), bc * twice};
    }
    const V ac = dot(a.R.z, c.R.z), gain = 2.0 / (1.0 - ac * ac);
    return {gain * (ab - ac * bc), gain * (bc - ac * ab)};
}

// Whether two joint vectors are images of each other in three joints from `first` on, and not copies of one.
template <int N> STEP bool are_images(const double* a, const double* b, int first) {
    for (int k = 0; k < N; ++k) {
        if ((k < first || k > first + 2) && !(a[k] == b[k])) return false;
    }
    const double change = abs(a[first + 1] - b[first + 1]);
    return change > SAME && abs(change - 2.0 * PI) > SAME;
}

// X (joints, width) becomes that of the image. The image of the image is the solution itself.
template <int width, class V> STEP void mirror(V* X, int first, const Projection<V>& on) {
    V* const a = X + width * first;
    V *const b = a + width, *const c = b + width;
    in_turn<0, width>([&](auto i) IN_PLACE { a[i] += on.alpha * b[i], c[i] += on.gamma * b[i], b[i] = -b[i]; });
}

}  // namespace urdf_ik::URDF_IK_LEVEL
