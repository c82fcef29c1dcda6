// Subproblems: the building blocks of the families. Most run without branching. Angles are given as (cos, sin).
//
// A subproblem with two solutions takes a sign. Besides the angles it returns a margin: zero where the two solutions meet, negative
// where there is no solution; the angles are then those of the double root. Frames are Denavit-Hartenberg frames in Craig's order,
// so every rotation is about z or x.
// Sources: Pieper 1968; Paden 1986 (subproblems 1 to 4); Elias and Wen 2022.
#pragma once

#include "numbers/thresholds.hpp"
#include "numbers/vectors.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

template <class V> struct Plane {
    V x, y;
};
// What is left of p across z without f, turned by psi.
template <class V> STEP Plane<V> rest_across(const Vec<V>& p, const Plane<V>& f, const Turn<V>& psi) {
    return {p.x - (psi.c * f.x - psi.s * f.y), p.y - (psi.s * f.x + psi.c * f.y)};
}

// The root of a margin. For a negative margin a single number gives zero, the double root. A block gives the root of the absolute
// value, so that the two branches stay apart: exact arms do not use these lanes, and imperfect arms need the margins of both
// branches (families/imperfect/imperfect.hpp).
STEP double margin_root(double margin) { return root(max(margin, 0.0)); }
template <int L, int K> STEP Pack<L, K> margin_root(const Pack<L, K>& margin) { return root(abs(margin)); }

// Turn about z so that (X, k) becomes (x, y), X free: subproblem 4.
template <class V> struct Swing {
    Turn<V> turn;
    V X, margin;  // margin r^2 - k^2 [m^2]
};
template <class V> STEP Swing<V> swing_to_offset(const V& x, const V& y, const V& k, const V& sign) {
    const V margin = x * x + y * y - k * k, X = sign * margin_root(margin);
    return {unit(X * x + k * y, X * y - k * x), X, margin};
}

// Planar two-link arm whose end is sqrt(uu) away: law of cosines. 1 + cos gamma and 1 - cos gamma are computed separately, so that
// a folded arm with equal links stays accurate.
template <class V> struct Fold {
    V wx, wy;  // the end, seen along the first link
    Turn<V> bend;  // gamma
    V margin;  // sin^2 gamma
};
template <class V, class W> STEP Fold<V> fold(const V& uu, const W& a, const W& b, double side, const V& sign) {
    const W w = 0.5 / (a * b), inner = a - b, outer = a + b;
    const V folded = (uu - inner * inner) * w, stretched = (outer * outer - uu) * w, margin = folded * stretched;
    const V c = min(max(0.5 * (folded - stretched), -1.0), V(1.0)), s = sign * margin_root(margin);
    return {inner + b * max(folded, 0.0), side * b * s, {c, s}, margin};
}

// a e(q2) + b e(q2 + side gamma) = (ux, uy), with e(q) = (cos q, sin q): fold, then subproblem 1.
template <class V> struct Elbow {
    Turn<V> second, bend;  // q2, gamma
    V margin;  // sin^2 gamma
};
template <class V, class W> STEP Elbow<V> elbow(const V& ux, const V& uy, const W& a, const W& b, double side, const V& sign) {
    const Fold<V> f = fold<V, W>(ux * ux + uy * uy, a, b, side, sign);
    return {unit(f.wx * ux + f.wy * uy, f.wx * uy - f.wy * ux), f.bend, f.margin};
}

// Two twists: cosines and sines of the angles from one axis to the next.
struct Twists {
    double ca, sa, cb, sb;
};

// Middle angle of a wrist whose last axis points along z in the frame of the first: subproblem 4. The angles between the axes are
// alpha and beta. The sine is computed from the part of the last axis across the first one, which is accurate also where the three
// axes lie in a plane.
template <class V> struct Bend {
    Turn<V> turn;
    V margin;  // sin^2
};
template <class V> STEP Bend<V> wrist_bend(const Vec<V>& z, const Twists& t, const V& sign) {
    const V c = (t.ca * t.cb - z.z) * (1.0 / (t.sa * t.sb)), across = t.ca * t.sb * c + t.sa * t.cb;
    const V margin = (z.x * z.x + z.y * z.y - across * across) * (1.0 / (t.sb * t.sb));
    return {unit(c, sign * margin_root(margin)), margin};
}

// Turn about z after which an axis tilted by alpha (ca, sa) from it, Rz(-t) (0, sa, ca), is at an angle with cosine c and squared
// sine `across` to a unit vector: subproblem 4. The margin is a product of two factors without cancellation, so the turn is
// accurate where the vectors align.
template <class V> STEP Bend<V> swing_to_tilt(const Vec<V>& z, double ca, double sa, const V& c, const V& across, const V& sign) {
    const V r = copysign(root(z.x * z.x + z.y * z.y), V(sa));
    const V c_low = ca * z.z + sa * r, s_low = sa * z.z - ca * r, c_high = ca * z.z - sa * r, s_high = sa * z.z + ca * r;
    const V above = select(c_low + c > V(0.5), (across - s_low * s_low) / (c_low + c), c_low - c);
    const V below = select(c_high + c < V(-0.5), (s_high * s_high - across) / (c_high + c), c - c_high);
    const V margin = above * below * (1.0 / (sa * sa)), k = (c - ca * z.z) * (1.0 / sa), X = sign * margin_root(margin);
    return {unit(X * z.x + k * z.y, k * z.x - X * z.y), margin};
}

// First and last angle of a wrist with a known bend: M = Rz(first) Rx(alpha) Rz(bend) Rx(beta) Rz(last). The last angle is
// computed after the first one is undone, so their sum stays exact where the axes align.
template <class V> struct WristTurns {
    Turn<V> first, last;
    V fixed;  // squared lever arm of the first turn; 0: only the sum of both turns matters
    V error;  // squared, of the rotation reached
};
// hold: use the given first turn, for a target that leaves it free.
template <class V>
STEP WristTurns<V> wrist_turns(const Rot<V>& M, const Turn<V>& bend, const Twists& t, bool hold = false,
                               Turn<V> held = {1.0, 0.0}) {
    const V X = t.sb * bend.s, Y = -(t.ca * t.sb * bend.c + t.sa * t.cb);
    const Turn<V> f = hold ? held : unit(X * M.z.x + Y * M.z.y, X * M.z.y - Y * M.z.x);
    const Vec<V> v = {f.c * bend.c - f.s * t.ca * bend.s, f.s * bend.c + f.c * t.ca * bend.s, t.sa * bend.s};
    const V ex = f.c * X - f.s * Y - M.z.x, ey = f.s * X + f.c * Y - M.z.y, ez = t.ca * t.cb - t.sa * t.sb * bend.c - M.z.z;
    const V ev = dot(v, M.z);
    return {f, {dot(v, M.x), -dot(v, M.y)}, X * X + Y * Y, ex * ex + ey * ey + ez * ez + ev * ev};
}

// wrist_bend and wrist_turns of a wrist whose twists are right angles, with one root; the margin is `fixed`.
template <class V> struct SquareWrist {
    Turn<V> first, bend, last;
    V fixed, error;
};
template <class V> STEP SquareWrist<V> square_wrist(const Rot<V>& M, const Twists& t) {
    const V fixed = M.z.x * M.z.x + M.z.y * M.z.y, over = inverse_sqrt(fixed + TINY), c = (-1.0 / (t.sa * t.sb)) * M.z.z,
            s = fixed * over;
    const Turn<V> first = {t.sb * M.z.x * over, t.sb * M.z.y * over};
    const Vec<V> v = {first.c * c, first.s * c, t.sa * s};
    const V along = dot(v, M.z), length = fixed + M.z.z * M.z.z - 1.0;
    return {first, {c, s}, {dot(v, M.x), -dot(v, M.y)}, fixed, along * along + length * length};
}

// The two turns of an aligned wrist, where only their sum (or difference) matters. The deviation from the wanted turns is split
// between them; share 0 keeps the first turn as wanted.
PART WristTurns<double> shared_turns(const Rot<double>& M, const Turn<double>& bend, const Twists& t, double first, double last,
                                     double share) {
    const double aligned = t.ca * t.cb - t.sa * t.sb * bend.c > 0.0 ? 1.0 : -1.0;
    WristTurns<double> turns = {};
    for (int round = 0; round < 2; ++round) {
        turns = wrist_turns(M, bend, t, true, exact_turn(first));
        first += 0.5 * share * aligned * wrap(wrap(angle(turns.last) - last));
    }
    return turns;
}

// Whether a margin is zero to rounding, so that the two solutions are one double root. The margin is a difference of squares: if
// the squared lever arm is small, so is the rounding error, and the solutions differ by half a turn instead of meeting.
STEP bool is_double(double margin, double arm, double rounding) { return margin <= rounding * sqrt(arm); }

}  // namespace urdf_ik::URDF_IK_LEVEL
