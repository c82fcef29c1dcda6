// One branch of a closed form, on numbers, blocks, balls or slanted numbers.
#pragma once

#include "arithmetic/slanted.hpp"
#include "kinematics/subproblems.hpp"
#include "kinematics/target.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A branch: the ideal arm's joint angles as (cos, sin), offsets included; the margins of shoulder, elbow and wrist, whose roots
// have the branch's signs (bits 4, 2 and 1 of its number); and the smallest squared lever arm of its angles (dimensionless).
// Margins and lever arms are reduced by the earlier joints' (see after).
template <class V> struct Branch {
    Turn<V> turn[6];
    V shoulder, elbow, wrist, arms;
};
// Arcs that a branch's angles are known to lie in. A closed form runs without them, or, on slanted numbers, with one arc for each
// joint: a turn that a step leaves wide or free is then taken from its arc, and what the step leaves of its equation must vanish.
struct NoArcs {
    template <class V> STEP Turn<V> met(int, const Turn<V>& turn) const { return turn; }
    template <class V> STEP Turn<V> met_by_root(int, const Turn<V>& turn) const { return turn; }
    template <class V> STEP void face(const Vec<V>&, const V&, const V&, Turn<V>&, V&) const {}
    template <class V> STEP WristTurns<V> wrist(int, int, const Rot<V>& M, const Turn<V>& bend, const Twists& t) const {
        return wrist_turns(M, bend, t);
    }
};
template <class B> struct Arcs {
    using V = Slanted<B>;
    Turn<V> of[6];
    mutable unsigned empty = 0;  // lanes in which an equation cannot hold
    mutable B low = -1.0, high = 1.0;  // where the parameter can be

    STEP Turn<V> met(int joint, const Turn<V>& turn) const { return met(of[joint], turn, turn); }
    // The same for a turn from a cosine and a margin's root, which unit() has not made an arc: next to a double root the sine is
    // far less certain than the cosine.
    STEP Turn<V> met_by_root(int joint, const Turn<V>& turn) const { return met(of[joint], unit(turn.c, turn.s), turn); }
    // Joint 1 turns (X, k) into (p.x, p.y); X has the sign of the branch.
    STEP void face(const Vec<V>& p, const V& k, const V& sign, Turn<V>& turn, V& X) const {
        turn = met(0, turn);
        const V along = p.x * turn.c + p.y * turn.s;
        vanish(p.y * turn.c - p.x * turn.s - k);
        empty |= bits((sign * along).greatest() < B(0.0));
        X = select(along.all.rad < X.all.rad, along, X);
    }
    // The outer turns of a wrist. If their axes are nearly aligned, each follows from the other one:
    // M Rz(-last) = Rz(first) Rx(alpha) Rz(bend) Rx(beta). first: -1 if no joint of its own makes this turn.
    STEP WristTurns<V> wrist(int first, int last, const Rot<V>& M, Turn<V>& bend, const Twists& t) const {
        const Turn<V>&l = of[last], found = wrist_turns(M, bend, t).first;
        const V wx = M.x.x * l.c - M.y.x * l.s, wy = M.x.y * l.c - M.y.y * l.s, y = t.ca * bend.s;
        const Turn<V> raw = unit(bend.c * wx + y * wy, bend.c * wy - y * wx);
        Turn<V> f = met(raw, found, found);
        if (first >= 0) {
            met(of[first], raw, raw), met(of[first], found, found);
            f = met(of[first], f, f);
        }
        // The last axis, seen from behind the first turn.
        const V along = M.z.x * f.c + M.z.y * f.s, across = M.z.y * f.c - M.z.x * f.s;
        vanish(across + (t.ca * t.sb * bend.c + t.sa * t.cb)), vanish(along - t.sb * bend.s);
        const V sine = along * (1.0 / t.sb);
        bend.s = select(sine.all.rad < bend.s.all.rad, sine, bend.s);
        return wrist_turns(M, bend, t, true, f);
    }

private:
    // The arc a, or unless it is clearly narrower than b what holds b's turn; both hold.
    STEP Turn<V> met(const Turn<V>& a, const Turn<V>& b, const Turn<V>& of_b) const {
        const B c = a.c.all.mid - b.c.all.mid, s = a.s.all.mid - b.s.all.mid, reach = a.c.all.rad + b.c.all.rad + 4.0 * ROUNDED;
        empty |= bits(c * c + s * s > 1.000000001 * (reach * reach));
        const auto first = a.c.all.rad < 0.7 * b.c.all.rad;
        const auto chosen = [&](const V& x, const V& y) {
            V out = select(first, x, y);
            out.all = select(x.all.rad < out.all.rad, x.all, out.all);
            return out;
        };
        return {chosen(a.c, of_b.c), chosen(a.s, of_b.s)};
    }
    STEP void vanish(const V& a) const {
        empty |= bits(abs(a.all.mid) > INFLATED * a.all.rad);
        // a(0) + t slope.mid is zero, within the slope's radius.
        const Ball<B> where = -Ball<B>(a.at.mid, a.at.rad + a.slope.rad) / Ball<B>(a.slope.mid);
        const auto known = where.rad < B(2.0);
        low = max(low, select(known, where.least(), B(-1.0))), high = min(high, select(known, where.greatest(), B(1.0)));
    }
};
// The signs of a block of branches; of closed forms with a quartic, its root.
template <class V> struct Signs {
    V shoulder, elbow, wrist;
    Turn<V> root = {};
};
// The squared lever arm of a joint, reduced by those of earlier joints. A small motion of the target moves a joint by the motion
// over its lever arm, or over the root of its margin, and this moves all later joints: `before` is the smallest of these squares.
template <class V> STEP V after(const V& arm, const V& before) { return arm * min(V(1.0), before); }

// Whether rounding may have changed the sign of one of the margins that a closed form computes one after the other.
//
// A step whose inputs err by e gives a margin m that errs by at most g e, and angles that err by at most g e / sqrt(m a): the
// root's error is that of the margin over the root, and a turn's error that of the vector over its length, the root of the squared
// lever arm a. So margin k errs by at most e g1 ... gk / sqrt(m1 a1 ... mk-1 ak-1), e being the targets' rounding. Its sign is
// right if mk^2 m1 a1 ... mk-1 ak-1 exceeds (e g1 g2 g3)^2, which is IdealFrames::together.
template <class V> struct Clear {
    V least, before;  // of mk^2 m1 a1 ... mk-1 ak-1; m1 a1 ... of the steps so far

    // The first step. A pose's first margin has no error from earlier steps: the fast path's edge exceeds its own.
    static STEP Clear first(const V& margin, const V& arm) { return {V(1.0), abs(margin) * arm}; }
    STEP Clear then(const V& margin, const V& arm) const {
        return {min(least, before * (margin * margin)), before * abs(margin) * arm};
    }
    STEP auto is_close(const V& last, double together) const { return min(least, before * (last * last)) <= V(together); }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
