// All complex solutions of a pose, from those of another pose by continuation.
//
// The joints' equations with complex angles have the same number of solutions at almost every pose, and each isolated
// solution of any pose is the end of a path of solutions that begins at such a pose and moves with it, on almost every path
// of complex poses between the two (Sommese and Wampler, The Numerical Solution of Systems of Polynomials, 2005, chapter 7:
// coefficient-parameter homotopy). Paths that end at a singular solution, or at infinity, are seen as such: so where all
// paths end apart from each other at regular solutions, no solution is missing, however round the pose is.
//
// The path of poses, at s from 1 (known) to 0 (asked for): quaternions (1 - s) q0 + s g q1, which need no length, and
// positions ((1 - s) p0 + s g p1) / (1 - s + s g), with a complex number g off the real line.
#pragma once

#include "../answer.hpp"
#include "../complex.hpp"
#include "continuation_arm.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

using CBlock = Complexes<Block>;

// Greatest correction of a step: rad, and share of the step itself. A path that is taken for another is noticed at the end,
// where two of them then meet.
inline constexpr double LARGEST_CORRECTION = 0.05, LARGEST_SHARE = 0.15;
// Next to a singularity rounding makes corrections of some 1e-8 rad: shorter steps count as long as this.
inline constexpr double FLOOR = 3e-7;
// A step longer than this [rad] is not tried. Steps are made as long as leads to corrections of the size AIM.
inline constexpr double LONGEST = 0.7, AIM = 0.02, AIM_SHARE = 0.04;
// A path that cannot be followed beyond this s, or in that many steps, ends at a singular solution.
inline constexpr double SHORTEST = 1e-15;
inline constexpr double MOST_STEPS = 150.0;
// A path leads to infinity where |e^(i angle)|^2 is beyond this, or below its inverse.
inline constexpr double INFINITE = 1e16;
// A path that was lost with an imaginary part above this is not taken for one that leads to a real solution. Arms near a special
// one have half of their solutions so far out, or farther, and these are left out: many cannot be followed.
inline constexpr double DISTANT = 4.0;
// Correction [rad] below which Newton's method has converged at the end of a path. Next to a singularity rounding alone is
// larger: then one below AT_WEAK_END after so many rounds.
inline constexpr double AT_END = 1e-9, AT_WEAK_END = 1e-6, ROUNDS_AT_END = 8.0;
// Two ends of paths nearer than this [rad, sizes] are one solution of a known pose, whose solutions are regular.
inline constexpr double SAME_SOLUTION = 1e-6;
// A path whose correction is still larger than this after so many rounds has left its way on its last step.
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

// The pose at s, and how it moves with s: a spatial twist, with the velocity of its own origin.
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
    // d q^-1, its vector part.
    const Vec<CBlock> w = (2.0 * inverse_norm) * (q.w * d.v - d.w * q.v - cross(d.v, q.v));
    const CBlock speed = inverse_size * (g * weight * weight);
    const Vec<double> apart = p1 - p0;
    at.twist = {{apart.x * speed, apart.y * speed, apart.z * speed, w.x, w.y, w.z}};
    return at;
}

// J x = a and J y = b by Gram and Schmidt's orthogonalisation; a and b become x and y.
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

// Newton's step at the joints z towards the pose at s, and how the solution moves with s.
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

// The complex solutions of a pose: which of them are regular, which of these next to a singularity, and the s at which the paths
// of the others stopped.
struct PathEnds {
    static constexpr int most = KnownPose::most;
    int many;
    ComplexJoints q[most];
    double left[most];
    bool regular[most], weak[most];
};

// A path in each lane, each with its own s and its own step. What is known of it: the last two places, one `way_back` apart,
// and the tangents there. A path that rests is corrected where it is: at its start, at its end, and where a step failed.
struct Walk {
    CBlock z[6];
    Six<CBlock> tangent, before, way_back;
    Block s, h, last, steps, at_end;
    MaskOf<Block> moves, rests;
};

STEP Six<CBlock> next_step(const Walk& walk) {
    // A cubic through both places: u in steps, from where it is (0) to where it was (1).
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

// Back to the last place but one, for a shorter step: Newton's method at the end has not followed from where the last one led.
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

// Ahead by a cubic, then one step of Newton's method, which gives the next tangent too. Returns the lanes that arrived at a
// regular end, those of them next to a singularity, and those that came to an end at all.
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

// All paths that begin at the solutions `from` of the known pose. A lane whose path has ended takes the next one.
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

// ---- all paths of a pose ---------------------------------------------------------------------------------------------

// Frame 6 in frame 1, as KnownPose has it.
STEP Frame<double> inner_pose(const Written<6>& arm, const Goal<double>& goal) {
    const auto &first = arm.step[0], &last = arm.step[6];
    const auto rotated = [](const double (&R)[3][3], const Vec<double>& a) {  // by the transpose
        return Vec<double>{R[0][0] * a.x + R[1][0] * a.y + R[2][0] * a.z, R[0][1] * a.x + R[1][1] * a.y + R[2][1] * a.z,
                           R[0][2] * a.x + R[1][2] * a.y + R[2][2] * a.z};
    };
    const auto& L = last.R;
    const auto& G = goal.R;
    // The rotation of frame 6 is that of the goal times the last step's transpose.
    const Rot<double> R = {combine(G, L[0][0], L[0][1], L[0][2]), combine(G, L[1][0], L[1][1], L[1][2]),
                           combine(G, L[2][0], L[2][1], L[2][2])};
    const Vec<double> p = goal.p - combine(R, last.t[0], last.t[1], last.t[2]) - vec<double>(first.t);
    return {each(R, [&](const Vec<double>& a) { return rotated(first.R, a); }), rotated(first.R, p)};
}

// Shepperd's method (1978), from the greatest of the four.
STEP Quaternion<double> quaternion_of(const Rot<double>& R) {
    const double t[4] = {R.x.x + R.y.y + R.z.z, R.x.x, R.y.y, R.z.z};
    int most = 0;
    for (int i = 1; i < 4; ++i) most = t[i] > t[most] ? i : most;
    const double a = R.y.z - R.z.y, b = R.z.x - R.x.z, c = R.x.y - R.y.x;  // 4 w (x, y, z)
    const double xy = R.x.y + R.y.x, yz = R.y.z + R.z.y, zx = R.z.x + R.x.z;
    const double own = 1.0 + 2.0 * t[most] - t[0];
    Quaternion<double> q;
    if (most == 0) q = {1.0 + t[0], {a, b, c}};
    else if (most == 1) q = {a, {own, xy, zx}};
    else if (most == 2) q = {b, {xy, own, yz}};
    else q = {c, {zx, yz, own}};
    const double w = 1.0 / sqrt(q.w * q.w + dot(q.v, q.v));
    return {w * q.w, w * q.v};
}

// How far apart two complex solutions are: the greatest difference of a joint, rad or sizes.
STEP double apart(const Written<6>& arm, const ComplexJoints& p, const ComplexJoints& q) {
    const auto &a = p.z, &b = q.z;
    double most = 0.0;
    for (int k = 0; k < 6; ++k) {
        const double re = a[k][0] - b[k][0], im = a[k][1] - b[k][1];
        const double length = arm.slides[k] ? 1.0 : b[k][0] * b[k][0] + b[k][1] * b[k][1];
        most = max(most, (re * re + im * im) / length);
    }
    return sqrt(most);
}

// How far from real a solution is: the greatest imaginary part of a joint [rad, sizes].
STEP double imaginary_part(const Written<6>& arm, const ComplexJoints& q) {
    const auto& z = q.z;
    double most = 0.0;
    for (int k = 0; k < 6; ++k) {
        const double square = z[k][0] * z[k][0] + z[k][1] * z[k][1];
        most = max(most, arm.slides[k] ? abs(z[k][1]) : 0.5 * abs(__builtin_log(square + TINY)));
    }
    return most;
}

// Paths that ended at the same solution, of which one left its own on the way: both count as lost. Returns how many paths
// have a regular end of their own.
PART int separate(const Written<6>& arm, PathEnds& ends) {
    bool met[PathEnds::most] = {};
    for (int i = 0; i < ends.many; ++i) {
        for (int k = 0; k < i; ++k) {
            if (ends.regular[i] && ends.regular[k] && apart(arm, ends.q[i], ends.q[k]) < arm.tolerances.duplicate) met[i] = true;
        }
    }
    int count = 0;
    for (int i = 0; i < ends.many; ++i) ends.regular[i] &= !met[i], count += ends.regular[i];
    return count;
}

// Cosine and sine that make a c + b s greatest.
STEP Turn<double> greatest(double a, double b) { return unit(a + TINY, b); }

STEP Frame<double> pose_of(const KnownPose& known) {
    const Quaternion<double> q = {known.turn[0], {known.turn[1], known.turn[2], known.turn[3]}};
    return {rotation_of(q, 1.0), vec<double>(known.point)};
}

// A known pose, turned about axes 1 and 6, which turns joints 1 and 6 of its solutions, so that it is as near as can be to the
// target: how near, the pose, the turns.
struct Nearby {
    double gain;
    Frame<double> pose;
    Turn<double> first, last;
};

PART Nearby turned_to(const Written<6>& arm, const KnownPose& known, const Frame<double>& target) {
    const double weight = 4.0 / (arm.size * arm.size);
    const Frame<double> K = pose_of(known);
    const Vec<double>& k = K.p;
    Nearby out = {0.0, K, {1.0, 0.0}, {1.0, 0.0}};
    const Rot<double>& G = target.R;
    const Vec<double>& g = target.p;
    for (int round = 0; round < 2; ++round) {
        // Turned about axis 6, then how far about axis 1: rows of both rotations.
        const Rot<double> L = turned(K, out.last).R;
        if (!arm.slides[0]) {
            const double along = L.x.x * G.x.x + L.y.x * G.y.x + L.z.x * G.z.x + L.x.y * G.x.y + L.y.y * G.y.y + L.z.y * G.z.y;
            const double across = L.x.x * G.x.y + L.y.x * G.y.y + L.z.x * G.z.y - L.x.y * G.x.x - L.y.y * G.y.x - L.z.y * G.z.x;
            out.first = greatest(along + weight * (k.x * g.x + k.y * g.y), across + weight * (k.x * g.y - k.y * g.x));
        }
        const Turn<double> back = {out.first.c, -out.first.s};
        const auto about = [&](Vec<double> a) { return unturn(a.x, a.y, back), a; };
        const Frame<double> F = {each(K.R, about), about(k)};
        if (!arm.slides[5]) out.last = greatest(dot(G.x, F.R.x) + dot(G.y, F.R.y), dot(G.x, F.R.y) - dot(G.y, F.R.x));
        out.pose = turned(F, out.last);
    }
    const Vec<double> d = out.pose.p - g;
    out.gain = dot(out.pose.R.x, G.x) + dot(out.pose.R.y, G.y) + dot(out.pose.R.z, G.z) - 0.5 * weight * dot(d, d);
    return out;
}

STEP Way way_between(const Frame<double>& from, const Frame<double>& to, double angle) {
    Way way = {quaternion_of(from.R), quaternion_of(to.R), from.p, to.p, 0.0, 0.0};
    const double sign = way.from.w * way.to.w + dot(way.from.v, way.to.v) < 0.0 ? -1.0 : 1.0;
    way.from = {sign * way.from.w, sign * way.from.v};
    const Turn<double> g = exact_turn(angle);
    way.g_re = g.c, way.g_im = g.s;
    return way;
}

// The complex solutions of the goal by continuation from the known pose that is nearest to it; the k-th further attempt starts
// from the k-th next one, and takes another way. attempt: below the number of known poses. Returns how many solutions are regular.
PART int continue_from_nearest(const Written<6>& arm, const Continuation& by, const Goal<double>& goal, int attempt,
                               PathEnds& ends) {
    const Frame<double> target = inner_pose(arm, goal);
    Nearby near[Continuation::most];
    for (int i = 0; i < by.poses; ++i) near[i] = turned_to(arm, by.known[i], target);
    int at = 0;
    for (int skip = 0; skip <= attempt; ++skip) {
        if (skip) near[at].gain = -__builtin_inf();
        for (int i = 0; i < by.poses; ++i) at = near[i].gain > near[at].gain ? i : at;
    }
    ComplexJoints from[KnownPose::most];
    const auto turn = [](double (&z)[2], const Turn<double>& t) { unturn(z[0], z[1], Turn<double>{t.c, -t.s}); };
    for (int i = 0; i < by.solutions; ++i) {
        from[i] = by.known[at].solution[i];
        turn(from[i].z[0], near[at].first), turn(from[i].z[5], near[at].last);
    }
    const double angle = (attempt % 2 ? -1.0 : 1.0) * (0.8 + 0.3 * (attempt / 2));
    follow_all(arm, way_between(near[at].pose, target, angle), from, by.solutions, ends);
    return separate(arm, ends);
}

// ---- known poses -------------------------------------------------------------------------------------------------------

// Adds a solution, or its conjugate, if it is not there yet.
STEP void add_solution(const Written<6>& arm, KnownPose& pose, int& many, ComplexJoints q, bool conjugate) {
    for (int k = 0; conjugate && k < 6; ++k) {
        // Of the conjugate angle: one over the conjugate of e^(i angle).
        auto& z = q.z[k];
        const double w = 1.0 / (z[0] * z[0] + z[1] * z[1] + TINY);
        if (arm.slides[k]) z[1] = -z[1];
        else z[0] *= w, z[1] *= w;
    }
    for (int i = 0; i < many; ++i) {
        if (apart(arm, q, pose.solution[i]) < SAME_SOLUTION) return;
    }
    if (many < KnownPose::most) pose.solution[many++] = q;
}

STEP KnownPose known_pose(const Written<6>& arm, const double (&q)[6], int& many) {
    const Frame<double> at = inner_pose(arm, place(arm, q).tip);
    const Quaternion<double> turn = quaternion_of(at.R);
    KnownPose pose = {{turn.w, turn.v.x, turn.v.y, turn.v.z}, {at.p.x, at.p.y, at.p.z}, {}};
    for (int k = 0; k < 6; ++k) {
        const Turn<double> t = exact_turn(q[k]);
        auto& z = pose.solution[0].z[k];
        z[0] = arm.slides[k] ? q[k] / arm.size : t.c, z[1] = arm.slides[k] ? 0.0 : t.s;
    }
    many = 1;
    return pose;
}

// Adds to `to` what the paths from `from` lead to, and its conjugates, since the pose is real.
PART void carry(const Written<6>& arm, const KnownPose& from, int many, KnownPose& to, int& many_to, double angle) {
    PathEnds ends;
    follow_all(arm, way_between(pose_of(from), pose_of(to), angle), from.solution, many, ends);
    separate(arm, ends);
    for (int i = 0; i < many; ++i) {
        if (!ends.regular[i]) continue;
        add_solution(arm, to, many_to, ends.q[i], false);
        add_solution(arm, to, many_to, ends.q[i], true);
    }
}

STEP void leave_out_distant(const Written<6>& arm, KnownPose& pose, int& many) {
    int kept = 0;
    for (int i = 0; i < many; ++i) {
        if (imaginary_part(arm, pose.solution[i]) <= DISTANT) pose.solution[kept++] = pose.solution[i];
    }
    many = kept;
}

// All solutions of the first of the poses of m joint vectors, by monodromy: paths that lead to other poses and back another
// way end at other solutions than they began (Duff et al., Solving polynomial systems via homotopy continuation and
// monodromy, 2019). It ends when all 16 are found, or when IDLE_ROUNDS rounds have found no new one. Then those of the other poses.
// near: whether the arm is near a special one. A pose whose joint vector is singular is not among them: where all are, the arm is
// singular everywhere.
inline constexpr int IDLE_ROUNDS = 8, MOST_TRIED = 64;
inline constexpr double REGULAR = 1e-3;
PART void find_known_poses(const Written<6>& arm, const double (*all)[6], int m, bool near, Continuation& out) {
    double q[MOST_TRIED][6];
    int regular = 0, many;
    for (int i = 0; i < m && regular < MOST_TRIED; ++i) {
        for (int j = 0; j < 6; ++j) q[regular][j] = all[i][j];
        regular += weakest_at(arm, place(arm, q[regular]).tip, q[regular]).value > REGULAR;
    }
    out.solutions = out.poses = 0, m = regular;
    if (m < 2) return;
    KnownPose base = known_pose(arm, q[0], many);
    for (int round = 0, idle = 0; many < KnownPose::most && idle < IDLE_ROUNDS && round < 60; ++round) {
        int many_there, before = many;
        KnownPose other = known_pose(arm, q[1 + round % (m - 1)], many_there);
        carry(arm, base, many, other, many_there, 0.5 + 0.37 * (round % 5));
        carry(arm, other, many_there, base, many, -0.6 - 0.31 * (round % 7));
        idle = many > before ? 0 : idle + 1;
    }
    if (near) leave_out_distant(arm, base, many);
    out.solutions = many;
    for (int i = 0; i < m && out.poses < Continuation::most; ++i) {
        int there;
        KnownPose other = known_pose(arm, q[i], there);
        if (i > 0) carry(arm, base, many, other, there, 0.9);
        else other = base, there = many;
        if (there == many) out.known[out.poses++] = other;
    }
}

}  // namespace urdf_ik::URDF_IK_LEVEL
