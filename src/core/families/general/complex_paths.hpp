// Follows paths of complex solutions while the pose moves from a known one to the target; continuation.hpp says why.
//
// The pose at s, from 1 (known) to 0 (target), has the quaternion (1 - s) q0 + s g q1, not normalised, and the position
// ((1 - s) p0 + s g p1) / (1 - s + s g). The complex number g has length one and is not real.
#pragma once

#include "answers/answer.hpp"
#include "certificate/loop.hpp"
#include "families/general/continuation_arm.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A step whose correction exceeds either bound is rejected: an absolute one [rad, sizes], and a share of the step. A
// path that jumps to another path is noticed at the end, where the two meet.
inline constexpr double LARGEST_CORRECTION = 0.05, LARGEST_SHARE = 0.15;
// Next to a singularity, rounding alone causes corrections of about 1e-8 rad: shorter steps count as long as this
// [rad].
inline constexpr double FLOOR = 3e-7;
// A step longer than LONGEST [rad] is rejected. The length of the next step is chosen so that its correction comes to
// AIM [rad], or to AIM_SHARE of the step if that is less.
inline constexpr double LONGEST = 0.7, AIM = 0.02, AIM_SHARE = 0.04;
// A path stops if s falls below SHORTEST without reaching zero, or after MOST_STEPS rounds.
inline constexpr double SHORTEST = 1e-15;
inline constexpr double MOST_STEPS = 150.0;
// A path has gone to infinity if |e^(i angle)|^2 of a joint exceeds this, or falls below its inverse; for a slide, if
// the square of its length [sizes] exceeds this.
inline constexpr double INFINITE = 1e16;
// At the end of a path Newton's method has converged if its correction is below AT_END [rad]. Next to a singularity
// rounding alone is larger: after ROUNDS_AT_END rounds a correction below AT_WEAK_END is enough.
inline constexpr double AT_END = 1e-9, AT_WEAK_END = 1e-6, ROUNDS_AT_END = 8.0;
// If the correction still exceeds ASTRAY [rad] after ROUNDS_ASTRAY rounds at the end, the last step went wrong: see
// go_back().
inline constexpr double ASTRAY = 1e-4, ROUNDS_ASTRAY = 3.0;

template <class V> struct Quaternion {
    V w;
    Vec<V> v;
};

template <class V> STEP Rot<V> rotation_of(const Quaternion<V>& q, const V& inverse_norm) {
    const V s = 2.0 * inverse_norm;
    const Vec<V>& v = q.v;
    const V xx = s * v.x * v.x, yy = s * v.y * v.y, zz = s * v.z * v.z;
    const V xy = s * v.x * v.y, yz = s * v.y * v.z, zx = s * v.z * v.x;
    const V wx = s * q.w * v.x, wy = s * q.w * v.y, wz = s * q.w * v.z;
    return {{V(1.0) - yy - zz, xy + wz, zx - wy}, {xy - wz, V(1.0) - zz - xx, yz + wx}, {zx + wy, yz - wx, V(1.0) - xx - yy}};
}

// A way from a known pose, s = 1, to the target, s = 0.
struct Way {
    Quaternion<double> from, to;
    Vec<double> from_point, to_point;
    double g_re, g_im;
};

// The pose at s, and its derivative by s: the velocity of the pose's origin [sizes], then the angular velocity.
struct OnWay {
    Rot<CBlock> R;
    Vec<CBlock> p;
    Six<CBlock> twist;
};

STEP OnWay on_way(const Way& way, const Block& s, double inverse_size) {
    const Block t = 1.0 - s;
    const CBlock g = {Block(way.g_re), Block(way.g_im)}, a = {t, Block(0.0)}, b = scaled(s, g);
    const auto mixed = [&](double to, double from) { return CBlock(a.re * to + b.re * from, b.im * from); };
    const auto change = [&](double to, double from) { return CBlock(g.re * from - to, g.im * from); };
    const auto &q0 = way.to, &q1 = way.from;
    const Quaternion<CBlock> q = {mixed(q0.w, q1.w), {mixed(q0.v.x, q1.v.x), mixed(q0.v.y, q1.v.y), mixed(q0.v.z, q1.v.z)}};
    const Quaternion<CBlock> d = {change(q0.w, q1.w), {change(q0.v.x, q1.v.x), change(q0.v.y, q1.v.y), change(q0.v.z, q1.v.z)}};
    const CBlock inverse_norm = inverse(q.w * q.w + dot(q.v, q.v)), weight = inverse(a + b);
    OnWay at;
    at.R = rotation_of(q, inverse_norm);
    const auto &p0 = way.to_point, &p1 = way.from_point;
    at.p = weight * Vec<CBlock>{mixed(p0.x, p1.x), mixed(p0.y, p1.y), mixed(p0.z, p1.z)};
    // The vector part of d q^-1.
    const Vec<CBlock> w = (2.0 * inverse_norm) * (q.w * d.v - d.w * q.v - cross(d.v, q.v));
    const CBlock speed = inverse_size * (g * weight * weight);
    const Vec<double> apart = p1 - p0;
    at.twist = {{apart.x * speed, apart.y * speed, apart.z * speed, w.x, w.y, w.z}};
    return at;
}

// Solves J x = a and J y = b by Gram-Schmidt orthogonalisation. x replaces a, y replaces b.
STEP void solve_both(Six<CBlock> (&J)[6], Six<CBlock>& a, Six<CBlock>& b) {
    const auto along = [](const Six<CBlock>& u, const Six<CBlock>& v) {
        CBlock sum = conj(u[0]) * v[0];
        for (int i = 1; i < 6; ++i) sum += conj(u[i]) * v[i];
        return sum;
    };
    CBlock R[6][6], x[6], y[6];
    Block w[6];
#pragma GCC unroll 1
    for (int k = 0; k < 6; ++k) {
        Block length = TINY;
        for (int i = 0; i < 6; ++i) length += square(J[k][i]);
        w[k] = 1.0 / sqrt(length);
        for (int i = 0; i < 6; ++i) J[k][i] = scaled(w[k], J[k][i]);
#pragma GCC unroll 1
        for (int l = k + 1; l < 6; ++l) {
            R[k][l] = along(J[k], J[l]);
            for (int i = 0; i < 6; ++i) J[l][i] = J[l][i] - R[k][l] * J[k][i];
        }
        x[k] = along(J[k], a), y[k] = along(J[k], b);
    }
#pragma GCC unroll 1
    for (int k = 5; k >= 0; --k) {
        for (int l = k + 1; l < 6; ++l) x[k] = x[k] - R[k][l] * a[l], y[k] = y[k] - R[k][l] * b[l];
        a[k] = scaled(w[k], x[k]), b[k] = scaled(w[k], y[k]);
    }
}

// Newton's step from the joints z towards the pose at s, and the derivative of the solution by s.
struct ComplexStep {
    Six<CBlock> correction, tangent;
};

PART ComplexStep complex_step(const Written<6>& arm, const Way& way, const CBlock (&z)[6], const Block& s) {
    Frame<CBlock> at = {{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}, {0.0, 0.0, 0.0}};
    Vec<CBlock> axis[6], point[6];
    const double inverse_size = 1.0 / arm.size;
#pragma GCC unroll 1
    for (int k = 0; k < 6; ++k) {
        axis[k] = at.R.z, point[k] = at.p;
        at = arm.slides[k] ? Frame<CBlock>{at.R, at.p + (arm.size * z[k]) * at.R.z} : turned(at, turn_of(z[k]));
        if (k < 5) at = beyond(at, arm.step[k + 1]);
    }
    Six<CBlock> J[6];
#pragma GCC unroll 1
    for (int k = 0; k < 6; ++k) {
        const Vec<CBlock>& h = axis[k];
        const Vec<CBlock> v = cross(h, CBlock(inverse_size) * (at.p - point[k]));
        J[k] = {{v.x, v.y, v.z, h.x, h.y, h.z}};
        if (arm.slides[k]) J[k] = {{h.x, h.y, h.z, 0.0, 0.0, 0.0}};
    }
    const OnWay goal = on_way(way, s, inverse_size);
    const Vec<CBlock> p = CBlock(inverse_size) * (goal.p - at.p);
    const Vec<CBlock> w = CBlock(0.5) * (cross(at.R.x, goal.R.x) + cross(at.R.y, goal.R.y) + cross(at.R.z, goal.R.z));
    ComplexStep out = {{{p.x, p.y, p.z, w.x, w.y, w.z}}, goal.twist};
    solve_both(J, out.correction, out.tangent);
    return out;
}

STEP Block largest_square(const Six<CBlock>& a) {
    Block most = square(a[0]);
    for (int k = 1; k < 6; ++k) most = max(most, square(a[k]));
    return most;
}

STEP void advance(const Written<6>& arm, CBlock (&z)[6], const Six<CBlock>& by) {
    for (int k = 0; k < 6; ++k) z[k] = arm.slides[k] ? z[k] + by[k] : z[k] * small_turn(by[k]);
}

// The ends of the paths: joints, the s at which each path stopped (left), whether the end is a regular solution, and
// whether this regular solution is next to a singularity (weak).
struct PathEnds {
    static constexpr int most = KnownPose::most;
    int many;
    ComplexJoints q[most];
    double left[most];
    bool regular[most], weak[most];
};

// One path per lane, each with its own s and step h. tangent belongs to the current point z, before to the previous
// point, way_back is the move from that point, last the step by which s fell. A path that rests gets Newton's
// corrections without a step: at its start, at its end, and after a rejected step.
struct Walk {
    CBlock z[6];
    Six<CBlock> tangent, before, way_back;
    Block s, h, last, steps, at_end;
    MaskOf<Block> moves, rests;
};

STEP Six<CBlock> next_step(const Walk& walk) {
    // A cubic through the last two points and their tangents. u counts in steps: 0 at the current point, 1 at the
    // previous.
    const Block zero = 0.0, &h = walk.h, &last = walk.last;
    const auto first = last <= zero;
    const Block u = -(h / select(first, h, last)), uu = u * u;
    const Block at_last = select(first, zero, (3.0 - 2.0 * u) * uu);
    const Block slope = select(first, -h, (uu - 2.0 * u + 1.0) * u * last);
    const Block slope_last = select(first, zero, (u - 1.0) * uu * last);
    Six<CBlock> by;
    for (int k = 0; k < 6; ++k) {
        const CBlock each = scaled(slope, walk.tangent[k]) + scaled(slope_last, walk.before[k]) - scaled(at_last, walk.way_back[k]);
        by[k] = {select(walk.rests, zero, each.re), select(walk.rests, zero, each.im)};
    }
    return by;
}

// Back to the previous point, for a step a fifth as long: from the last point Newton's method did not converge at the
// end.
STEP void go_back(const Written<6>& arm, Walk& walk, const MaskOf<Block>& astray) {
    Six<CBlock> back;
    for (int k = 0; k < 6; ++k) {
        back[k] = select<Block>(astray, -walk.way_back[k], 0.0);
        walk.tangent[k] = select<Block>(astray, walk.before[k], walk.tangent[k]);
    }
    advance(arm, walk.z, back);
    walk.s = select(astray, walk.last, walk.s), walk.h = select(astray, 0.2 * walk.last, walk.h);
    walk.last = select(astray, Block(0.0), walk.last), walk.at_end = select(astray, Block(0.0), walk.at_end);
}

// One step along the cubic, then one step of Newton's method, which also gives the next tangent. Returns the lanes that
// reached a regular end. weak: those of them next to a singularity; ended: all lanes whose path stopped.
PART unsigned walk_on(const Written<6>& arm, const Way& way, Walk& walk, unsigned& weak, unsigned& ended) {
    const Block zero = 0.0;
    walk.h = min(walk.h, walk.s);
    const Six<CBlock> by = next_step(walk);
    CBlock z[6];
    for (int k = 0; k < 6; ++k) z[k] = walk.z[k];
    advance(arm, z, by);
    const Block ahead = select(walk.rests, walk.s, select(walk.h < walk.s, walk.s - walk.h, zero));
    const ComplexStep step = complex_step(arm, way, z, ahead);
    const Block size = largest_square(step.correction), length = largest_square(by) + FLOOR * FLOOR;
    const Block largest = LARGEST_CORRECTION * LARGEST_CORRECTION, bound = min(LARGEST_SHARE * LARGEST_SHARE * length, largest);
    const auto arrived = walk.moves & !walk.rests & (size <= bound) & (length < Block(LONGEST * LONGEST));
    const auto good = arrived | (walk.moves & walk.rests & (size < largest));
    advance(arm, z, step.correction);
    Block far = 0.0;
    for (int k = 0; k < 6; ++k) {
        walk.z[k] = select<Block>(good, z[k], walk.z[k]);
        walk.way_back[k] = select<Block>(arrived, by[k], walk.way_back[k]) + select<Block>(good, step.correction[k], 0.0);
        walk.before[k] = select<Block>(arrived, walk.tangent[k], walk.before[k]);
        walk.tangent[k] = select<Block>(good, step.tangent[k], walk.tangent[k]);
        const Block each = square(walk.z[k]);
        far = max(far, arm.slides[k] ? each : max(each, 1.0 / (each + TINY)));
    }
    // The correction grows with the fourth power of the step, its square with the eighth.
    const Block aim = min(AIM_SHARE * AIM_SHARE * length, Block(AIM * AIM));
    const Block grown = min(sqrt(sqrt(sqrt(aim / (size + TINY)))), Block(4.0));
    const Block shorter = select(walk.rests, Block(1.0), 0.8 * max(min(grown, Block(0.6)), Block(0.1)));
    const auto at_end = walk.moves & walk.rests & (walk.s <= zero);
    weak = bits(at_end & (size < Block(AT_WEAK_END * AT_WEAK_END)) & (walk.at_end >= Block(ROUNDS_AT_END)));
    const unsigned regular = bits(at_end & (size < Block(AT_END * AT_END))) | weak;
    const auto astray = at_end & (walk.at_end >= Block(ROUNDS_ASTRAY)) & (size > Block(ASTRAY * ASTRAY)) & (walk.last > zero);
    walk.last = select(arrived, walk.h, walk.last);
    walk.s = select(arrived, ahead, walk.s);
    walk.h = walk.h * select(arrived, max(grown, Block(0.5)), shorter);
    const auto there = walk.s <= zero;
    walk.rests = (walk.moves & !arrived & !walk.rests) | there;
    if (any(astray)) go_back(arm, walk, astray);
    walk.steps += 1.0, walk.at_end += select(there, Block(1.0), 0.0);
    const auto stuck = (walk.s < Block(SHORTEST)) & !there;
    ended = regular | bits(walk.moves & (stuck | (far > Block(INFINITE)) | (walk.steps > Block(MOST_STEPS)) |
                                         (walk.at_end > Block(ROUNDS_AT_END))));
    return regular;
}

// Follows the paths of all solutions `from` of the known pose. A lane whose path has ended takes the next one.
PART void follow_all(const Written<6>& arm, const Way& way, const ComplexJoints* from, int many, PathEnds& to) {
    Walk walk = {};
    int path[BLOCK], next = 0;
    Six<CBlock>* const vectors[3] = {&walk.tangent, &walk.before, &walk.way_back};
    const auto begin = [&](int l) {
        path[l] = next < many ? next++ : -1;
        for (int k = 0; k < 6; ++k) {
            const double (&z)[2] = from[path[l] < 0 ? 0 : path[l]].z[k];
            walk.z[k].re.set(l, z[0]), walk.z[k].im.set(l, z[1]);
            for (Six<CBlock>* each : vectors) (*each)[k].re.set(l, 0.0), (*each)[k].im.set(l, 0.0);
        }
        walk.s.set(l, 1.0), walk.h.set(l, 0.1);
        walk.last.set(l, 0.0), walk.steps.set(l, 0.0), walk.at_end.set(l, 0.0);
    };
    to.many = many;
    double moves[BLOCK], rests[BLOCK];
    for (int l = 0; l < BLOCK; ++l) begin(l), moves[l] = path[l] >= 0, rests[l] = 1.0;
    walk.moves = load<Block>(moves) > Block(0.0), walk.rests = load<Block>(rests) > Block(0.0);
    while (any(walk.moves)) {
        unsigned weak, ended;
        const unsigned regular = walk_on(arm, way, walk, weak, ended);
        if (!ended) continue;
        const unsigned resting = bits(walk.rests);
        for (int l = 0; l < BLOCK; ++l) {
            rests[l] = (resting | ended) >> l & 1;
            if (!(ended >> l & 1)) continue;
            const int i = path[l];
            to.left[i] = walk.s[l], to.regular[i] = regular >> l & 1, to.weak[i] = weak >> l & 1;
            for (int k = 0; k < 6; ++k) to.q[i].z[k][0] = walk.z[k].re[l], to.q[i].z[k][1] = walk.z[k].im[l];
            begin(l), moves[l] = path[l] >= 0;
        }
        walk.moves = load<Block>(moves) > Block(0.0), walk.rests = load<Block>(rests) > Block(0.0);
    }
}

}  // namespace urdf_ik::URDF_IK_LEVEL
