// All solutions of six revolute joints whose last three axes meet (Pieper 1968): up to four places of the first three
// joints, two wrists each. Columns: 4 front/back + 2 up/down + noflip/flip.
#pragma once

#include "families/blocks.hpp"
#include "families/closed_forms/wrist_position.hpp"
#include "numbers/quartic.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The rotation of the target in frame 3.
template <class V> STEP Rot<V> wrist_rotation(const Rot<V>& R, const IdealFrames& arm, const Place<V>& at) {
    const Turn<double> a1 = {arm.cos_alpha[0], arm.sin_alpha[0]}, a2 = {arm.cos_alpha[1], arm.sin_alpha[1]};
    const Turn<double> a3 = {arm.cos_alpha[2], arm.sin_alpha[2]};
    return each(R, [&](Vec<V> v) {
        unturn(v.x, v.y, at.t1), unturn(v.y, v.z, a1);
        unturn(v.x, v.y, at.t2), unturn(v.y, v.z, a2);
        unturn(v.x, v.y, at.t3), unturn(v.y, v.z, a3);
        return v;
    });
}

template <Shoulder kind> struct SphericalWrist {
    using Arm = SphericalWristArm;
    static constexpr int branches = 8;
    static constexpr bool by_signs = kind != Shoulder::general;
    static constexpr int flags[3] = {SHOULDER, ELBOW, WRIST};  // of the singularities of its margins
    static constexpr unsigned root_bit = 2, root_joint = 2;  // see proposals.hpp
    static constexpr bool by_height = kind == Shoulder::parallel_23;  // the shoulder's margin comes before the elbow's

    // Angles of a block that are computed together, which gives the processor independent work: t1 of both fronts and
    // the bend of their elbows (parallel_23), or t3 of both elbows and t1 of each pair; then t2 and the wrist's turns
    // of each pair.
    using Angles = AnglesOf<32>;
    // Margins and squared arms of a place of the first three joints, and the squared error of its position.
    struct Margins {
        Block shoulder, elbow, arms, error;
        Clear<Block> clear;
    };
    static constexpr int OUTER = 0, BEND = 2, SECOND = 4, FIFTH = 8, FOURTH = 12, SIXTH = 16, FOURTH_FLIPPED = 20,
                         SIXTH_FLIPPED = 24;
    static constexpr int FIRST = 28;

    static STEP void fast(const Arm& arm, const Seen<Block>& seen, Found<8>& found) {
        if (arm.square_wrist) solve<true>(arm, seen, found);
        else solve<false>(arm, seen, found);
    }

    template <bool square> static STEP void solve(const Arm& arm, const Seen<Block>& seen, Found<8>& found) {
        Angles at;
        State state[4];
        if constexpr (kind == Shoulder::parallel_23) {
            for (int outer = 0; outer < 2; ++outer) one_front<square>(arm, seen, outer, at, state);
        } else {
            for (int outer = 0; outer < 2; ++outer) one_elbow<square>(arm, seen, outer, at, state);
        }
        angles<0, 20>(at.y, at.x);
        if constexpr (!square) angles<20, 28>(at.y, at.x);
        if constexpr (kind != Shoulder::parallel_23) angles<28, 32>(at.y, at.x);
        combine<square>(arm, at, state, found);
    }

    // Both elbows of one front of the arm. Axes 2 and 3 are parallel, so joints 2 and 3 turn the wrist by one angle.
    template <bool square>
    static STEP void one_front(const Arm& arm, const Seen<Block>& seen, int outer, Angles& at, State (&state)[4]) {
        const auto& ideal = arm.ideal;
        const double side = ideal.cos_alpha[1], size2 = 1.0 / (ideal.size * ideal.size);
        const Front<Block> front = face<Block>(arm, seen.p, ideal.signs[0][4 * outer]);
        at.set(OUTER + outer, front.t1);
        const Rot<Block> R = each(seen.R, [&](const Vec<Block>& v) { return before_second(ideal, v, front.t1); });
        // The distance of the wrist centre from its place on the arm's plane, at this angle of joint 1.
        const Vec<Block> p = before_second(ideal, seen.p, front.t1) - Vec<Block>{Block(ideal.a[0]), Block(0.0), Block(0.0)};
        const Block off_plane = p.z - arm.height, off_x = p.x - front.ux, off_y = p.y - front.uy;
        const Block off1 = off_plane * off_plane + off_x * off_x + off_y * off_y;
        const Block uu = front.ux * front.ux + front.uy * front.uy, arm2 = uu * size2;
        const Fold<Block> f = fold<Block>(uu, ideal.a[1], arm.rho, side, 1.0);
        const auto& [c, s] = f.bend;
        at.set(BEND + outer, f.bend);
        const Block along = ideal.a[1] + arm.rho * c;
        const Block c_even = f.wx * front.ux, c_odd = f.wy * front.uy, s_even = f.wx * front.uy, s_odd = f.wy * front.ux;
        const Block arm1 = (seen.p.x * seen.p.x + seen.p.y * seen.p.y) * size2;
        Margins margins = {front.margin, f.margin, min(arm1, arm2), 0.0,
                           Clear<Block>::first(front.margin, arm1).then(f.margin, arm2)};
        for (int e = 0; e < 2; ++e) {
            const int pair = 2 * outer + e;
            const double up = ideal.signs[1][2 * pair];
            const Turn<Block> t2 = unit(c_even + up * c_odd, s_even - up * s_odd);
            const Block us = up * s, across = up * f.wy;
            const Turn<Block> t3 = {c * arm.cos_phi + us * arm.sin_phi, us * arm.cos_phi - c * arm.sin_phi};
            const Turn<Block> t23 = {t2.c * t3.c - side * (t2.s * t3.s), t2.s * t3.c + side * (t2.c * t3.s)};
            const Block ex = t2.c * along - t2.s * across - front.ux, ey = t2.s * along + t2.c * across - front.uy;
            at.set(SECOND + pair, t2);
            margins.error = (off1 + ex * ex + ey * ey) * (2.0 * size2);
            state[pair] = wrists<square>(arm, after_third(ideal, R, t23), margins, pair, at);
        }
    }

    // A vector of frame 1 seen after joint 1 has turned and alpha 1.
    static STEP Vec<Block> before_second(const IdealFrames& arm, Vec<Block> v, const Turn<Block>& t1) {
        unturn(v.x, v.y, t1), unturn(v.y, v.z, Turn<double>{arm.cos_alpha[0], arm.sin_alpha[0]});
        return v;
    }
    // A rotation of that frame seen after joints 2 and 3, whose axes are parallel, have turned it by t23, and alpha 3.
    static STEP Rot<Block> after_third(const IdealFrames& arm, const Rot<Block>& R, const Turn<Block>& t23) {
        const double side = arm.cos_alpha[1];
        const Turn<double> a3 = {side * arm.cos_alpha[2], side * arm.sin_alpha[2]};
        return each(R, [&](Vec<Block> v) {
            unturn(v.x, v.y, t23), unturn(v.y, v.z, a3);
            return v;
        });
    }

    // Both fronts of one elbow.
    template <bool square>
    static STEP void one_elbow(const Arm& arm, const Seen<Block>& seen, int outer, Angles& at, State (&state)[4]) {
        const Third<kind, Block> elbow = third<kind, Block>(arm, seen.p, arm.ideal.signs[1][2 * outer]);
        at.set(OUTER + outer, elbow.t3);
        for (int inner = 0; inner < 2; ++inner) {
            const int pair = 2 * inner + outer;
            const Place<Block> place = first_two<kind, Block>(arm, seen.p, elbow, {Block(arm.ideal.signs[0][2 * pair]), 1.0, 1.0});
            at.set(FIRST + pair, place.t1), at.set(SECOND + pair, place.t2);
            const Margins margins = {place.margin1, place.margin2, min(place.arm1, place.arm2), place.error,
                                     Clear<Block>::first(place.margin2, 1.0).then(place.margin1, place.arm1 * place.arm2)};
            state[pair] = wrists<square>(arm, wrist_rotation(seen.R, arm.ideal, place), margins, pair, at);
        }
    }

    // Both wrists of one place of the first three joints; M: the target's rotation seen from frame 3.
    template <bool square>
    static STEP State wrists(const Arm& arm, const Rot<Block>& M, const Margins& place, int pair, Angles& at) {
        const auto& ideal = arm.ideal;
        const Twists t = {ideal.cos_alpha[3], ideal.sin_alpha[3], ideal.cos_alpha[4], ideal.sin_alpha[4]};
        Block margin, fixed, off;
        if constexpr (square) {
            const SquareWrist<Block> wrist = square_wrist(M, t);
            margin = fixed = wrist.fixed, off = wrist.error;
            at.set(FIFTH + pair, wrist.bend), at.set(FOURTH + pair, wrist.first), at.set(SIXTH + pair, wrist.last);
        } else {
            const Bend<Block> bend = wrist_bend<Block>(M.z, t, 1.0);
            const WristTurns<Block> turns = wrist_turns(M, bend.turn, t), flipped = wrist_turns(M, {bend.turn.c, -bend.turn.s}, t);
            margin = bend.margin, fixed = turns.fixed, off = max(turns.error, flipped.error);
            at.set(FIFTH + pair, bend.turn), at.set(FOURTH + pair, turns.first), at.set(SIXTH + pair, turns.last);
            at.set(FOURTH_FLIPPED + pair, flipped.first), at.set(SIXTH_FLIPPED + pair, flipped.last);
        }
        const Tolerances& tol = arm.written.tolerances;
        const Block least = min(min(place.shoulder, place.elbow), margin), arms = min(place.arms, fixed);
        const auto doubt = (min(least, arms) <= Block(tol.edge)) | !(place.error + off <= Block(tol.reach * tol.reach * 1e-2));
        // Past the end of an earlier step's branch, later steps are inaccurate.
        const Block &first = by_height ? place.shoulder : place.elbow, &second = by_height ? place.elbow : place.shoulder;
        const auto lost = (first < Block(-tol.edge)) | ((second < Block(-tol.edge)) & (min(first, place.arms) > Block(tol.edge))) |
                          ((margin < Block(-tol.edge)) & (min(min(first, second), place.arms) > Block(tol.edge)));
        return {lost, doubt, place.clear.is_close(margin, ideal.together)};
    }

    // Joint values from the angles, less the offsets.
    template <bool square>
    static STEP void combine(const Arm& arm, const Angles& at, const State (&state)[4], Found<8>& found) {
        const double* offset = arm.ideal.offset;
        const Block* angle = at.y;
        for (int pair = 0; pair < 4; ++pair) {
            Block q[6], flipped[6];
            if constexpr (kind == Shoulder::parallel_23) {
                q[0] = wrap(angle[OUTER + pair / 2] - offset[0]);
                q[2] = wrap(arm.ideal.signs[1][2 * pair] * angle[BEND + pair / 2] - arm.bend_offset);
            } else {
                q[0] = wrap(angle[FIRST + pair] - offset[0]), q[2] = wrap(angle[OUTER + pair % 2] - offset[2]);
            }
            q[1] = wrap(angle[SECOND + pair] - offset[1]);
            q[3] = wrap(angle[FOURTH + pair] - offset[3]);
            q[4] = wrap(angle[FIFTH + pair] - offset[4]);
            q[5] = wrap(angle[SIXTH + pair] - offset[5]);
            for (int j = 0; j < 3; ++j) flipped[j] = q[j];
            flipped[4] = wrap(-angle[FIFTH + pair] - offset[4]);
            if constexpr (square) {
                flipped[3] = half_turn_from(q[3]), flipped[5] = half_turn_from(q[5]);
            } else {
                flipped[3] = wrap(angle[FOURTH_FLIPPED + pair] - offset[3]),
                flipped[5] = wrap(angle[SIXTH_FLIPPED + pair] - offset[5]);
            }
            found.set(2 * pair, q, state[pair].lost, state[pair].doubt);
            found.set(2 * pair + 1, flipped, state[pair].lost, state[pair].doubt);
            found.unproven |= bits(state[pair].close);
        }
    }

    template <class V> static STEP Branch<V> branch(const Arm& arm, const Seen<V>& seen, const Signs<V>& signs) {
        const auto& ideal = arm.ideal;
        const Twists t = {ideal.cos_alpha[3], ideal.sin_alpha[3], ideal.cos_alpha[4], ideal.sin_alpha[4]};
        const Place<V> at = position<kind, V>(arm, seen.p, signs);
        const Rot<V> M = wrist_rotation(seen.R, ideal, at);
        const Bend<V> bend = wrist_bend(M.z, t, signs.wrist);
        const WristTurns<V> turns = wrist_turns(M, bend.turn, t, signs, 3);
        const V arms = min(at.arm1, at.arm2), before = min(min(abs(at.margin1), abs(at.margin2)), arms);
        return {{at.t1, at.t2, unit(at.t3.c, at.t3.s), turns.first, bend.turn, unit(turns.last.c, turns.last.s)},
                at.margin1,
                at.margin2,
                bend.margin,
                min(arms, after(turns.fixed, before)),
                {by_height ? at.arm1 : arms, by_height ? at.arm2 : V(1.0), turns.fixed}};
    }

    // Third angles of a general shoulder: the length of p and its height fix u_x and u_y as affine functions of (cos,
    // sin); u_x^2 + u_y^2 + u_z^2 = f^2 is then a trigonometric polynomial of degree two (Pieper 1968).
    static PART Quartic quartic(const Arm& arm, const Seen<double>& seen) {
        const Vec<double>& p = seen.p;
        const double off = slack_of(arm.ideal, seen).shift;
        const double a1 = arm.ideal.a[0], ca1 = arm.ideal.cos_alpha[0], sa1 = arm.ideal.sin_alpha[0];
        // f is affine in (cos, sin), and |f|^2 too, since the squares of (cos, sin) add up to one.
        const Vec<double> zero = second_link<double>(arm, {0.0, 0.0}), c = second_link<double>(arm, {1.0, 0.0}),
                          s = second_link<double>(arm, {0.0, 1.0});
        const Vec<double> minus_c = second_link<double>(arm, {-1.0, 0.0}), minus_s = second_link<double>(arm, {0.0, -1.0});
        const double f0 = 0.5 * (dot(c, c) + dot(minus_c, minus_c)), fc = 0.5 * (dot(c, c) - dot(minus_c, minus_c));
        const double fs = 0.5 * (dot(s, s) - dot(minus_s, minus_s));
        const double k = (dot(p, p) - a1 * a1 - f0) / (2.0 * a1), kc = -fc / (2.0 * a1), ks = -fs / (2.0 * a1);
        const double h = zero.z, hc = c.z - h, hs = s.z - h;
        const double v = (p.z - ca1 * h) / sa1, vc = -ca1 * hc / sa1, vs = -ca1 * hs / sa1;
        const double scale = 1.0 / (arm.ideal.size * arm.ideal.size);
        const double constant = (k * k + v * v + h * h - f0) * scale;
        const double cc = (kc * kc + vc * vc + hc * hc) * scale, ss = (ks * ks + vs * vs + hs * hs) * scale;
        // The terms' sizes; the error of p in them, and less than 64 units of roundoff.
        const double F = f0 + abs(fc) + abs(fs), H = abs(h) + abs(hc) + abs(hs);
        const double K = (dot(p, p) + a1 * a1 + F) / (2.0 * a1), V = (abs(p.z) + abs(ca1) * H) / abs(sa1);
        const double error = 2.0 * off * (K * (sqrt(dot(p, p)) + off) / a1 + V / abs(sa1)) + 7e-15 * (K * K + V * V + H * H + F);
        return trigonometric_roots(
            {constant + 0.5 * (cc + ss), (2.0 * (k * kc + v * vc + h * hc) - fc) * scale,
             (2.0 * (k * ks + v * vs + h * hs) - fs) * scale, 0.5 * (cc - ss), (kc * ks + vc * vs + hc * hs) * scale},
            error * scale);
    }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
