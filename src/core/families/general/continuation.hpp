// All complex solutions of a pose, from those of another pose by continuation.
//
// With complex angles the loop equations have the same number of solutions at almost every pose. Let a path of complex
// poses lead from such a pose to the target. On almost every such path, each isolated solution of the target is the end
// of a path of solutions that starts at the first pose (Sommese and Wampler, The Numerical Solution of Systems of
// Polynomials, 2005, chapter 7: coefficient-parameter homotopy). A path that ends at a singular solution or at infinity
// is recognised. So if all paths end at different regular solutions, none is missing, even at poses with round numbers.
#pragma once

#include "families/general/complex_paths.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A lost path with an imaginary part above this [rad, sizes] is assumed to lead to no real solution. An arm near a
// special one has half of its solutions this far from real, or farther. Its known poses leave these out: many cannot be
// followed.
inline constexpr double DISTANT = 4.0;

// Shepperd's method (1978), from the largest of the four components.
PART Quaternion<double> quaternion_of(const Rot<double>& R) {
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

// The greatest difference of two complex solutions in a joint [rad, sizes].
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

// The greatest imaginary part of a joint, in magnitude [rad, sizes]; zero for a real solution.
STEP double imaginary_part(const Written<6>& arm, const ComplexJoints& q) {
    const auto& z = q.z;
    double most = 0.0;
    for (int k = 0; k < 6; ++k) {
        const double square = z[k][0] * z[k][0] + z[k][1] * z[k][1];
        most = max(most, arm.slides[k] ? abs(z[k][1]) : 0.5 * abs(logarithm(square + TINY)));
    }
    return most;
}

// If several paths ended at one solution, all but the first count as lost: one of them jumped to another path. Returns
// the number of different regular ends.
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

// The (c, s) that maximise a c + b s.
STEP Turn<double> greatest(double a, double b) { return unit(a + TINY, b); }

STEP Frame<double> pose_of(const KnownPose& known) {
    const Quaternion<double> q = {known.turn[0], {known.turn[1], known.turn[2], known.turn[3]}};
    return {rotation_of(q, 1.0), vec<double>(known.point)};
}

// A known pose, turned about axes 1 and 6 to be as near as possible to the target: a measure of nearness, the pose, the
// turns. Its solutions turn along in joints 1 and 6.
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
        // The pose turned about axis 6, then its best turn about axis 1: products of rows of both rotations.
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

// The complex solutions of the goal by continuation from a known pose: the nearest one at attempt 0, the k-th next at
// attempt k, each along another path of poses. attempt is below the number of known poses. Returns the number of
// different regular solutions.
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

// Adds a solution, or its conjugate, if it is not there yet.
PART void add_solution(const Written<6>& arm, KnownPose& pose, int& many, ComplexJoints q, bool conjugate) {
    for (int k = 0; conjugate && k < 6; ++k) {
        // The conjugate angle has one over the conjugate of e^(i angle).
        auto& z = q.z[k];
        const double w = 1.0 / (z[0] * z[0] + z[1] * z[1] + TINY);
        if (arm.slides[k]) z[1] = -z[1];
        else z[0] *= w, z[1] *= w;
    }
    for (int i = 0; i < many; ++i) {
        if (apart(arm, q, pose.solution[i]) < SAME) return;
    }
    if (many < KnownPose::most) pose.solution[many++] = q;
}

PART KnownPose known_pose(const Written<6>& arm, const double (&q)[6], int& many) {
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

// Adds to `to` the regular ends of the paths from `from`, and their conjugates, which are solutions since the pose is
// real.
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

// Finds all solutions at the pose of the first regular joint vector by monodromy: paths that lead to another pose and
// back by another way end at other solutions than they started from (Duff et al., Solving polynomial systems via
// homotopy continuation and monodromy, 2019). This stops when all 16 are found, or after IDLE_ROUNDS rounds without a
// new one. Paths then lead to the other poses, and a pose that gets as many solutions is kept.
// On many arms with slides the solutions of all poses form several separate surfaces, and no loop leads from one to
// another. The joint vector of each other pose adds a start on its own surface, so more rounds are allowed.
// near: whether the arm is near a special one; solutions far from real are then left out. Singular joint vectors are
// skipped. With fewer than two regular ones, as on an arm that is singular everywhere, there are no known poses.
inline constexpr int IDLE_ROUNDS = 8, IDLE_ROUNDS_WITH_SLIDES = 100, MOST_ROUNDS = 120, MOST_TRIED = 128;
PART void find_known_poses(const Written<6>& arm, const double (*all)[6], int m, bool near, Continuation& out) {
    double q[MOST_TRIED][6];
    int regular = 0, many;
    for (int i = 0; i < m && regular < MOST_TRIED; ++i) {
        for (int j = 0; j < 6; ++j) q[regular][j] = all[i][j];
        regular += weakest_at(arm, place(arm, q[regular]).tip, q[regular]).value > NEAR;
    }
    out.solutions = out.poses = 0, m = regular;
    if (m < 2) return;
    KnownPose base = known_pose(arm, q[0], many);
    bool slides = false;
    for (const bool each : arm.slides) slides |= each;
    const int patience = slides ? IDLE_ROUNDS_WITH_SLIDES : IDLE_ROUNDS;
    for (int round = 0, idle = 0; many < KnownPose::most && idle < patience && round < MOST_ROUNDS; ++round) {
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
