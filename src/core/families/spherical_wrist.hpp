// All solutions of six revolute joints whose last three axes meet (Pieper 1968): up to four places of the first three
// joints, two wrists each. Columns: 4 front/back + 2 up/down + noflip/flip.
#pragma once

#include "../blocks.hpp"
#include "quartic.hpp"
#include "wrist_position.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The target's rotation seen from frame 3.
template <class V> STEP Rot<V> wrist_rotation(const Rot<V>& R, const IdealFrames& arm, const Place<V>& at) {
    const Turn<double> a1 = {arm.cos_alpha[0], arm.sin_alpha[0]}, a2 = {arm.cos_alpha[1], arm.sin_alpha[1]};
    const Turn<double> a3 = {arm.cos_alpha[2], arm.sin_alpha[2]};
    const auto seen = [&](Vec<V> v) {
        unturn(v.x, v.y, at.t1), unturn(v.y, v.z, a1);
        unturn(v.x, v.y, at.t2), unturn(v.y, v.z, a2);
        unturn(v.x, v.y, at.t3), unturn(v.y, v.z, a3);
        return v;
    };
    return {seen(R.x), seen(R.y), seen(R.z)};
}

template <Shoulder kind> struct SphericalWrist {
    using Arm = SphericalWristArm;
    static constexpr int branches = 8;

    // Joints 1 to 3 of both elbows of one front, or both fronts of one elbow, and their wrists.
    template <class Out> static STEP void fast(const Arm& arm, const Seen<Block>& seen, Out& found) {
        const double(&signs)[8][3] = arm.ideal.signs;
        const double* offset = arm.ideal.offset;
        for (int outer = 0; outer < 2; ++outer) {
            if constexpr (kind == Shoulder::parallel_23) {
                const Front<Block> front = face<Block>(arm, seen.p, signs[4 * outer][0]);
                const Block q1 = wrap(angle(front.t1) - offset[0]);
                Block bend = 0.0;
                for (int inner = 0; inner < 2; ++inner) {
                    const double up = signs[4 * outer + 2 * inner][1];
                    const Place<Block> at = bend_elbow<Block>(arm, seen.p, front, up, {});
                    const Turn<Block> t3 = at.t3;
                    // The elbow's bend before its sign: t3 + phi.
                    if (inner == 0) bend = up * angle(Turn<Block>{t3.c * arm.cos_phi - t3.s * arm.sin_phi, t3.s * arm.cos_phi + t3.c * arm.sin_phi});
                    const Block q3 = wrap(up * bend - arm.bend_offset);
                    both_wrists(arm, seen.R, at, q1, wrap(angle(at.t2) - offset[1]), q3, 4 * outer + 2 * inner, found);
                }
            } else {
                const Third<kind, Block> elbow = third<kind, Block>(arm, seen.p, signs[2 * outer][1]);
                const Block q3 = wrap(angle(elbow.t3) - offset[2]);
                for (int inner = 0; inner < 2; ++inner) {
                    const Place<Block> at = first_two<kind, Block>(arm, seen.p, elbow, signs[4 * inner][0], {});
                    both_wrists(arm, seen.R, at, wrap(angle(at.t1) - offset[0]), wrap(angle(at.t2) - offset[1]), q3,
                                4 * inner + 2 * outer, found);
                }
            }
        }
    }

    template <class Out>
    static STEP void both_wrists(const Arm& arm, const Rot<Block>& R, const Place<Block>& at, const Block& q1, const Block& q2,
                                 const Block& q3, int b, Out& found) {
        const auto& ideal = arm.ideal;
        const Twists t = {ideal.cos_alpha[3], ideal.sin_alpha[3], ideal.cos_alpha[4], ideal.sin_alpha[4]};
        const double edge = arm.written.tolerances.edge, reach = arm.written.tolerances.reach;
        const Rot<Block> M = wrist_rotation(R, ideal, at);
        const Bend<Block> bend = wrist_bend<Block>(M.z, t, 1.0);
        const Turn<Block> back = {bend.turn.c, -bend.turn.s};
        const WristTurns<Block> turns = wrist_turns(M, bend.turn, t);
        Block error = turns.error;
        const Block q4 = wrap(angle(turns.first) - ideal.offset[3]), q6 = wrap(angle(turns.last) - ideal.offset[5]);
        const Block t5 = angle(bend.turn), q5 = wrap(t5 - ideal.offset[4]), q5_flipped = wrap(-t5 - ideal.offset[4]);
        Block q4_flipped, q6_flipped;
        if (arm.square_wrist) {
            q4_flipped = half_turn_from(q4), q6_flipped = half_turn_from(q6);
        } else {
            const WristTurns<Block> flipped = wrist_turns(M, back, t);
            q4_flipped = wrap(angle(flipped.first) - ideal.offset[3]), q6_flipped = wrap(angle(flipped.last) - ideal.offset[5]);
            error = max(error, flipped.error);
        }
        const Block least = min(min(at.margin1, at.margin2), bend.margin);
        const Block arms = min(min(at.arm1, at.arm2), turns.fixed);
        const auto lost = least < Block(-edge);
        const auto doubt = (min(least, arms) <= Block(edge)) | !(at.error + error <= Block(reach * reach * 1e-2));
        const Clearance<Block> clear = clearance(ideal.stride, at.margin1, at.margin2, bend.margin, arms);
        found.set(b, {q1, q2, q3, q4, q5, q6}, lost, doubt, clear);
        found.set(b + 1, {q1, q2, q3, q4_flipped, q5_flipped, q6_flipped}, lost, doubt, clear);
    }

    // A margin within `fold` of zero is a double root, of which one branch is kept; a joint that the target leaves free
    // (squared arm below `continuum`) takes the reference's value.
    static PART void closely(const Arm& arm, const Goal<double>& goal, const Seen<double>& seen, const Reference<6>& reference,
                             const Columns<6>& columns, unsigned wanted) {
        Quartic roots = {};
        roots.count = 4;
        if constexpr (kind == Shoulder::general) roots = shoulder_roots(arm, seen.p);
        for (int pair = 0; pair < roots.count && pair < 4; ++pair) {
            if (wanted >> 2 * pair & 3u) wrists_closely(arm, goal, seen, reference, columns, wanted, pair, roots);
        }
    }

    // What is known of a place of the first three joints, its root settled.
    struct Settled {
        Place<double> at;
        int marks;
        bool near, kept;
    };

    static STEP Settled settle(const Arm& arm, const Vec<double>& p, const Reference<6>& reference, int pair, const Quartic& roots) {
        const auto& ideal = arm.ideal;
        const Tolerances& tol = arm.written.tolerances;
        constexpr bool by_height = kind == Shoulder::parallel_23, quartic = kind == Shoulder::general;
        double front = ideal.signs[2 * pair][0], up = ideal.signs[2 * pair][1];
        Settled out = {position<kind>(arm, p, front, up, roots.root[pair]), 0, false, false};
        const double m1 = quartic ? roots.gap(pair) : out.at.margin1, m2 = out.at.margin2, arm1 = out.at.arm1, arm2 = out.at.arm2;
        out.near = min(abs(m1), abs(m2)) < NEAR || min(arm1, arm2) < NEAR;
        if (m1 < -ideal.clamp || m2 < -ideal.clamp) return out;
        const bool free1 = arm1 <= tol.continuum, free2 = arm2 <= tol.continuum;
        if ((m1 <= tol.fold && !quartic) || free1 || (free2 && !by_height)) out.marks |= SHOULDER;
        if (m2 <= tol.fold || (free2 && by_height)) out.marks |= ELBOW;
        if (!quartic) {
            // Of two signs that stand for the same root, or the same continuum, the positive one is kept, as zero.
            const double swung = by_height ? arm1 : kind == Shoulder::intersecting_12 ? min(arm1, arm2) : 1.0;
            const double links = by_height ? 2.0 * ideal.a[1] * arm.rho / (ideal.size * ideal.size) : 1.0;
            const bool double1 = is_double(m1, swung, ROUNDING), double2 = is_double(m2, by_height ? arm2 : 1.0, ROUNDING / links);
            if (front < 0.0 && (double1 || free1 || (free2 && !by_height))) return out;
            if (up < 0.0 && (double2 || (free2 && by_height))) return out;
            front = double1 ? 0.0 : front, up = double2 ? 0.0 : up;
        }
        if (free1 || free2 || front == 0.0 || up == 0.0) {
            Held hold = {free1, free2};
            hold.turn1 = exact_turn(reference.q[0] + ideal.offset[0]), hold.turn2 = exact_turn(reference.q[1] + ideal.offset[1]);
            out.at = position<kind>(arm, p, front, up, roots.root[pair], hold);
        }
        out.kept = true;
        return out;
    }

    static STEP Turn<double> exact_turn(double angle) { return {__builtin_cos(angle), __builtin_sin(angle)}; }

    static PART void wrists_closely(const Arm& arm, const Goal<double>& goal, const Seen<double>& seen, const Reference<6>& reference,
                                    const Columns<6>& columns, unsigned wanted, int pair, const Quartic& roots) {
        const auto& ideal = arm.ideal;
        const Tolerances& tol = arm.written.tolerances;
        const Twists t = {ideal.cos_alpha[3], ideal.sin_alpha[3], ideal.cos_alpha[4], ideal.sin_alpha[4]};
        const Settled place = settle(arm, seen.p, reference, pair, roots);
        if (!place.kept) return;
        const Rot<double> M = wrist_rotation(seen.R, ideal, place.at);
        for (int b = 2 * pair; b < 2 * pair + 2; ++b) {
            if (!(wanted >> b & 1u)) continue;
            const double flip = ideal.signs[b][2];
            Bend<double> bend = wrist_bend(M.z, t, flip);
            // The quartic's roots are rough where it is ill-conditioned: let Newton's method decide.
            if (bend.margin < -(kind == Shoulder::general ? max(ideal.clamp, ROUGH) : ideal.clamp)) continue;
            WristTurns<double> turns = wrist_turns(M, bend.turn, t);
            const int marks = place.marks | (min(turns.fixed, bend.margin) <= tol.fold ? WRIST : 0);
            const bool double3 = is_double(bend.margin, turns.fixed, ROUNDING / (t.sb * t.sb));
            if (flip < 0.0 && (double3 || turns.fixed <= tol.continuum)) continue;
            if (double3) {
                bend.turn = wrist_bend(M.z, t, 0.0).turn;
                turns = wrist_turns(M, bend.turn, t);
            }
            const bool near = place.near || abs(bend.margin) < NEAR || turns.fixed < NEAR;
            if (turns.fixed <= tol.continuum) turns = shared_turn(M, bend.turn, t, ideal, reference);
            const Turn<double> found[6] = {place.at.t1, place.at.t2, place.at.t3, turns.first, bend.turn, turns.last};
            double q[6];
            for (int j = 0; j < 6; ++j) q[j] = wrap(angle(found[j]) - ideal.offset[j]);
            accept(arm.written, goal, q, b, marks, near, columns);
        }
    }

    // Only the sum (or the difference) of the two turns counts: its distance from the reference is shared among them.
    static STEP WristTurns<double> shared_turn(const Rot<double>& M, const Turn<double>& bend, const Twists& t, const IdealFrames& ideal,
                                               const Reference<6>& reference) {
        double first = reference.q[3] + ideal.offset[3];
        WristTurns<double> turns = {};
        for (int round = 0; round < 2; ++round) {
            turns = wrist_turns(M, bend, t, true, exact_turn(first));
            const double rest = wrap(wrap(angle(turns.last) - ideal.offset[5]) - reference.q[5]);
            const double aligned = t.ca * t.cb - t.sa * t.sb * bend.c > 0.0 ? 1.0 : -1.0;
            first += 0.5 * reference.given * aligned * rest;
        }
        return turns;
    }

    // Third angles of a general shoulder: the length of p and its height fix u_x and u_y as affine functions of (cos,
    // sin); u_x^2 + u_y^2 + u_z^2 = f^2 is then a trigonometric polynomial of degree two (Pieper 1968).
    static PART Quartic shoulder_roots(const Arm& arm, const Vec<double>& p) {
        const double a1 = arm.ideal.a[0], ca1 = arm.ideal.cos_alpha[0], sa1 = arm.ideal.sin_alpha[0];
        // f is affine in (cos, sin), and |f|^2 too, since the squares of (cos, sin) add up to one.
        const Vec<double> zero = second_link<double>(arm, {0.0, 0.0}), c = second_link<double>(arm, {1.0, 0.0}), s = second_link<double>(arm, {0.0, 1.0});
        const Vec<double> minus_c = second_link<double>(arm, {-1.0, 0.0}), minus_s = second_link<double>(arm, {0.0, -1.0});
        const double f0 = 0.5 * (dot(c, c) + dot(minus_c, minus_c)), fc = 0.5 * (dot(c, c) - dot(minus_c, minus_c));
        const double fs = 0.5 * (dot(s, s) - dot(minus_s, minus_s));
        const double k = (dot(p, p) - a1 * a1 - f0) / (2.0 * a1), kc = -fc / (2.0 * a1), ks = -fs / (2.0 * a1);
        const double h = zero.z, hc = c.z - h, hs = s.z - h;
        const double v = (p.z - ca1 * h) / sa1, vc = -ca1 * hc / sa1, vs = -ca1 * hs / sa1;
        const double scale = 1.0 / (arm.ideal.size * arm.ideal.size);
        const double constant = (k * k + v * v + h * h - f0) * scale;
        const double cc = (kc * kc + vc * vc + hc * hc) * scale, ss = (ks * ks + vs * vs + hs * hs) * scale;
        return trigonometric_roots({constant + 0.5 * (cc + ss), (2.0 * (k * kc + v * vc + h * hc) - fc) * scale,
                                    (2.0 * (k * ks + v * vs + h * hs) - fs) * scale, 0.5 * (cc - ss),
                                    (kc * ks + vc * vs + hc * hs) * scale});
    }
};

// A general shoulder has no signs to take side by side: every pose is looked at closely.
template <>
template <class Out>
STEP void SphericalWrist<Shoulder::general>::fast(const Arm&, const Seen<Block>&, Out& found) {
    found.leave_open();
}

}  // namespace urdf_ik::URDF_IK_LEVEL
