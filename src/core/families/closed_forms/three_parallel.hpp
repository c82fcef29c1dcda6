// All solutions of six revolute joints whose axes 2, 3 and 4 are parallel.
//
// Joints 2 to 4 shift the wrist across the parallel axes and turn it about them by one angle phi; heights along the
// axes do not change. The components along them therefore give joints 1 and 5. phi and joint 6 follow like two turns of
// a wrist, and a planar two-link arm gives joints 2 to 4. Sources: Hawkins 2013 (Universal Robots); Elias and Wen 2022
// (three parallel axes). Columns: 4 front/back + 2 up/down + noflip/flip.
#pragma once

#include "arm/linked_angles.hpp"
#include "arm/subproblems.hpp"
#include "families/blocks.hpp"
#include "families/closed_forms/three_parallel_arm.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

STEP Twists twists(const ThreeParallelArm& arm) {
    return {arm.cos_first, arm.sin_first, arm.ideal.cos_alpha[4], arm.ideal.sin_alpha[4]};
}

// A vector of frame 1 in the frame that joint 1 has turned, with z along the parallel axes.
template <class V> STEP Vec<V> seen_along(const ThreeParallelArm& arm, Vec<V> v, const Turn<V>& t1) {
    unturn(v.x, v.y, t1), unturn(v.y, v.z, Turn<double>{arm.ideal.cos_alpha[0], arm.ideal.sin_alpha[0]});
    return v;
}
template <class V> STEP Seen<V> seen_along(const ThreeParallelArm& arm, const Seen<V>& at, const Turn<V>& t1) {
    Vec<V> p = seen_along(arm, at.p, t1);
    p.x = p.x - arm.ideal.a[0];
    return {each(at.R, [&](const Vec<V>& v) { return seen_along(arm, v, t1); }), p};
}

// Joint 1 of an arm whose axes 5 and 6 meet, in a point at a known height along the parallel axes.
template <class V> STEP Swing<V> face(const ThreeParallelArm& arm, const Vec<V>& p, const V& front) {
    const V k = (arm.ideal.cos_alpha[0] * p.z - arm.along) * (1.0 / arm.ideal.sin_alpha[0]);
    return swing_to_offset(p.x, p.y, k, front);
}

// Step from axis 4 to the origin of frame 6, across the parallel axes, before the turn phi [m].
template <class V> STEP Plane<V> forearm(const ThreeParallelArm& arm, const Turn<V>& t5) {
    const double a5 = arm.ideal.a[4];
    return {arm.ideal.a[3] + a5 * t5.c, arm.cos_first * a5 * t5.s - arm.sin_first * arm.ideal.d[3]};
}

// Joint 5 of a general hand, from its height along the parallel axes; `tilt`: cosine of the angle from them to axis 6.
template <class V> STEP Turn<V> skew_bend(const ThreeParallelArm& arm, const V& tilt, const V& height) {
    const Twists t = twists(arm);
    return unit((t.ca * t.cb - tilt) * (1.0 / (t.sa * t.sb)), (height - arm.along) * (1.0 / (t.sa * arm.ideal.a[4])));
}

// The component of a vector along the parallel axes, by the angle of joint 1.
STEP Affine<double> along(const ThreeParallelArm& arm, const Vec<double>& v) {
    return {arm.ideal.cos_alpha[0] * v.z, -arm.ideal.sin_alpha[0] * v.y, arm.ideal.sin_alpha[0] * v.x};
}

// Angles of joint 1 of an arm whose axes 5 and 6 are skew: direction and height of axis 6 along the parallel axes give
// cos t5 and sin t5. The angles are sharpened where axis 6 is almost parallel to axes 2 to 4.
PART Quartic first_angles(const ThreeParallelArm& arm, const Seen<double>& seen) {
    const Twists t = twists(arm);
    const double w = -1.0 / (t.sa * t.sb);
    Affine<double> cosine = scaled(along(arm, seen.R.z), w), sine = scaled(along(arm, seen.p), 1.0 / (t.sa * arm.ideal.a[4]));
    cosine.constant -= t.ca * t.cb * w, sine.constant -= arm.along / (t.sa * arm.ideal.a[4]);
    const Slack off = slack_of(arm.ideal, seen);
    Quartic roots = linked_roots(cosine, sine, 2.0 * abs(w) * off.turn, 2.0 * off.shift / abs(t.sa * arm.ideal.a[4]));
    const Affine<double> tilt = along(arm, seen.R.z);
    for (int k = 0; k < 2; ++k) {
        const double side = k ? -1.0 : 1.0;
        const Turn<double> at = unit(side * tilt.cosine, side * tilt.sine);
        const Bend<double> bend = wrist_bend(seen_along(arm, seen.R.z, at), t, 1.0);
        sharpen_roots({at, bend.turn.c, bend.margin, -w * (tilt.cosine * at.c + tilt.sine * at.s)}, sine, roots);
    }
    return roots;
}

template <Hand kind> struct ThreeParallel {
    using Arm = ThreeParallelArm;
    static constexpr int branches = 8;
    static constexpr bool by_signs = kind != Hand::general;
    static constexpr int flags[3] = {SHOULDER, ELBOW, WRIST};  // of the singularities of its margins
    static constexpr unsigned root_bit = 1, root_joint = 0;  // see proposals.hpp

    // Angles of a block that are computed together, which gives the processor independent work: joints 1 and 5 of both
    // shoulders; phi and joint 6 of both, or of all four wrists; the elbow's bend for these; joint 2 of all branches.
    using Angles = AnglesOf<28>;
    static constexpr int FIRST = 0, FIFTH = 2, PHI = 4, SIXTH = 6, BEND = 8, SECOND = 12, PHI_FLIPPED = 20, SIXTH_FLIPPED = 22;
    // Margins, squared arms and error of the steps before the elbow.
    struct Upstream {
        Block margin1, margin5, arm1, fixed, error;
        Clear<Block> clear;
    };

    static STEP void fast(const Arm& arm, const Seen<Block>& seen, Found<8>& found) {
        if (arm.square_wrist) solve_block<true>(arm, seen, found);
        else solve_block<false>(arm, seen, found);
    }

    // One shoulder after the other; wrists and elbows share intermediate results.
    template <bool square> static STEP void solve_block(const Arm& arm, const Seen<Block>& seen, Found<8>& found) {
        Angles at;
        State state[4];
        for (int shoulder = 0; shoulder < 2; ++shoulder) one_shoulder<square>(arm, seen, shoulder, at, state);
        angles<0, 20>(at.y, at.x);
        if constexpr (!square) angles<20, 24>(at.y, at.x);
        for (int k = 0; k < 4; ++k) combine<square>(arm, at, k, state[k], found);
    }

    template <bool square>
    static STEP void one_shoulder(const Arm& arm, const Seen<Block>& seen, int shoulder, Angles& at, State (&state)[4]) {
        const auto& ideal = arm.ideal;
        const Twists t = twists(arm);
        const double scale = 1.0 / (ideal.size * ideal.size);
        const Swing<Block> first = face<Block>(arm, seen.p, ideal.signs[0][4 * shoulder]);
        const Seen<Block> from = seen_along(arm, seen, first.turn);
        const Block high = (from.p.z - arm.along) * (1.0 / ideal.size), arm1 = (seen.p.x * seen.p.x + seen.p.y * seen.p.y) * scale;
        at.set(FIRST + shoulder, first.turn);
        const auto elbows = [&](const Turn<Block>& bend, const Block& margin, const WristTurns<Block>& turns, int flip) {
            const Block margin1 = first.margin * scale;
            const Upstream up = {margin1,
                                 margin,
                                 arm1,
                                 turns.fixed,
                                 turns.error + high * high,
                                 Clear<Block>::first(margin1, arm1).then(margin, turns.fixed)};
            state[2 * shoulder + flip] =
                both_elbows(arm, up, rest_across(from.p, forearm(arm, bend), turns.first), 2 * shoulder + flip, at);
        };
        if constexpr (square) {
            const SquareWrist<Block> wrist = square_wrist(from.R, t);
            at.set(FIFTH + shoulder, wrist.bend), at.set(PHI + shoulder, wrist.first), at.set(SIXTH + shoulder, wrist.last);
            elbows(wrist.bend, wrist.fixed, {wrist.first, wrist.last, wrist.fixed, wrist.error}, 0);
            const Turn<Block> back = {wrist.bend.c, -wrist.bend.s}, opposite = {-wrist.first.c, -wrist.first.s};
            elbows(back, wrist.fixed, {opposite, wrist.last, wrist.fixed, wrist.error}, 1);
        } else {
            const Bend<Block> bend = wrist_bend<Block>(from.R.z, t, 1.0);
            const Turn<Block> back = {bend.turn.c, -bend.turn.s};
            const WristTurns<Block> turns = wrist_turns(from.R, bend.turn, t), flip = wrist_turns(from.R, back, t);
            at.set(FIFTH + shoulder, bend.turn), at.set(PHI + shoulder, turns.first), at.set(SIXTH + shoulder, turns.last);
            at.set(PHI_FLIPPED + shoulder, flip.first), at.set(SIXTH_FLIPPED + shoulder, flip.last);
            elbows(bend.turn, bend.margin, turns, 0), elbows(back, bend.margin, flip, 1);
        }
    }

    // k: 2 front/back + noflip/flip.
    static STEP State both_elbows(const Arm& arm, const Upstream& up, const Plane<Block>& u, int k, Angles& at) {
        const auto& ideal = arm.ideal;
        const double edge = arm.written.tolerances.edge, reach = arm.written.tolerances.reach,
                     scale = 1.0 / (ideal.size * ideal.size);
        const Block uu = u.x * u.x + u.y * u.y;
        const Fold<Block> f = fold<Block>(uu, ideal.a[1], ideal.a[2], arm.turn_3, 1.0);
        // The links, turned towards axis 4, miss it by the difference of the lengths, at most miss / |u|.
        const Block miss = f.wx * f.wx + f.wy * f.wy - uu;
        const Block arms = min(min(up.arm1, uu * scale), up.fixed), before = min(up.margin1, up.margin5);
        const Block xx = f.wx * u.x, xy = f.wx * u.y, yx = f.wy * u.x, yy = f.wy * u.y;
        at.set(BEND + k, f.bend), at.set(SECOND + 2 * k, {xx + yy, xy - yx}), at.set(SECOND + 2 * k + 1, {xx - yy, xy + yx});
        // If the wrist leaves phi free, another phi may bring the elbow within reach. Past the end of an earlier step's
        // branch, later steps are inaccurate.
        const auto lost = (up.margin1 < Block(-edge)) | ((up.margin5 < Block(-edge)) & (up.margin1 > Block(edge))) |
                          ((f.margin < Block(-edge)) & (min(before, min(up.fixed, up.arm1)) > Block(edge)));
        const auto doubt = (min(min(before, f.margin), arms) <= Block(edge)) |
                           !(miss * miss * scale + up.error * uu <= (reach * reach * 1e-2) * uu);
        return {lost, doubt, up.clear.is_close(f.margin, ideal.together)};
    }

    // Joint values from the angles, less the offsets.
    template <bool square> static STEP void combine(const Arm& arm, const Angles& at, int k, const State& state, Found<8>& found) {
        const double* offset = arm.ideal.offset;
        const Block* angle = at.y;
        const int shoulder = k / 2, flip = k % 2;
        const Block q1 = wrap(angle[FIRST + shoulder] - offset[0]),
                    q5 = wrap((flip ? -angle[FIFTH + shoulder] : angle[FIFTH + shoulder]) - offset[4]);
        Block phi = angle[(flip && !square ? PHI_FLIPPED : PHI) + shoulder];
        Block q6 = wrap(angle[(flip && !square ? SIXTH_FLIPPED : SIXTH) + shoulder] - offset[5]);
        if (flip && square) phi = half_turn_from(phi), q6 = half_turn_from(q6);
        found.unproven |= bits(state.close);
        for (int down = 0; down < 2; ++down) {
            const Block t2 = angle[SECOND + 2 * k + down], t3 = down ? -angle[BEND + k] : angle[BEND + k];
            const Block t4 = arm.turn_4 * (phi - (t2 + arm.turn_3 * t3));
            found.set(4 * shoulder + 2 * down + flip,
                      {q1, wrap(t2 - offset[1]), wrap(t3 - offset[2]), wrap(wrap(t4 - offset[3])), q5, q6}, state.lost,
                      state.doubt);
        }
    }

    // phi where joints 2 to 4 have the values of free joints.
    static STEP Turn<double> free_phi(const Arm& arm, const FreeJoints* free) {
        if (!free) return {};
        Turn<double> phi = free->turn[1];
        for (int j = 2; j < 4; ++j) {
            unturn(phi.c, phi.s, Turn<double>{free->turn[j].c, -(j == 2 ? arm.turn_3 : arm.turn_4) * free->turn[j].s});
        }
        return phi;
    }

    template <class V> static STEP Branch<V> branch(const Arm& arm, const Seen<V>& seen, const Signs<V>& signs) {
        const auto& ideal = arm.ideal;
        const Twists t = twists(arm);
        const double scale = 1.0 / (ideal.size * ideal.size);
        Swing<V> first = {signs.root, V(0.0), V(ideal.size * ideal.size)};
        if constexpr (by_signs) first = face(arm, seen.p, signs.shoulder);
        const V arm1 = (seen.p.x * seen.p.x + seen.p.y * seen.p.y) * scale, margin1 = first.margin * scale;
        const Turn<V> t1 = by_signs ? unless_free(signs, 0, arm1, first.turn) : first.turn;
        const Seen<V> from = seen_along(arm, seen, t1);
        Bend<V> bend = {{V(0.0), V(0.0)}, V(1.0)};
        if constexpr (by_signs) bend = wrist_bend(from.R.z, t, signs.wrist);
        else bend.turn = skew_bend(arm, from.R.z.z, from.p.z);
        const WristTurns<V> turns = wrist_turns(from.R, bend.turn, t, signs, free_phi(arm, signs.free));
        const Plane<V> u = rest_across(from.p, forearm(arm, bend.turn), turns.first);
        const Elbow<V> e = elbow(u.x, u.y, ideal.a[1], ideal.a[2], arm.turn_3, signs.elbow);
        const V arm2 = (u.x * u.x + u.y * u.y) * scale, front = min(abs(margin1), arm1);
        const V wrist = min(abs(bend.margin), turns.fixed);
        const V arms = min(arm1, min(after(turns.fixed, front), after(arm2, min(front, wrist))));
        const Turn<V> t2 = unless_free(signs, 1, arm2, e.second), t3 = unit(e.bend.c, e.bend.s);
        Turn<V> t4 = turns.first;
        unturn(t4.c, t4.s, t2), unturn(t4.c, t4.s, Turn<V>{t3.c, arm.turn_3 * t3.s});
        return {{t1, t2, t3, unit(t4.c, arm.turn_4 * t4.s), bend.turn, unit(turns.last.c, turns.last.s)},
                margin1,
                e.margin,
                bend.margin,
                arms,
                {arm1, arm2, turns.fixed}};
    }

    // All angles of joint 1.
    static Quartic quartic(const Arm& arm, const Seen<double>& seen) { return first_angles(arm, seen); }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
