// Interval inclusion at a swivel angle: boxes that hold every solution of an S-R-S arm, as in families/inclusion.hpp.
//
// The ideal arm I has the axes' directions of the arm as written, W, which it leaves by e_k at axis k. At one joint vector the two
// tips are turned alike, and I's is ahead by sum_k R_1 ... R_{k-1} (1 - R_k) e_k. So W reaches a target where I reaches the target
// moved by that, at most 2 sum |e_k|. The closed form runs on balls that hold all these targets; in the boxes that it gives, the
// sum varies less, and the closed form runs again. Axis 4 has one direction in both arms, and is perpendicular to `level`, which
// the target and the swivel angle fix.
#pragma once

#include "families/inclusion.hpp"
#include "families/seven_joints/srs.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// How often the closed form runs on an arm that is not exact. It decides the cost only.
inline constexpr int BOX_SRS_PASSES = 5;

// Joints 2, 4 and 6 with their offsets. The roots of the three margins have bits 4, 2 and 1 of a branch's number.
using SrsBoxes = BoxesOf<7>;
// Targets of the ideal arm in frame 1, one for each branch [m]: all within `radius` of `p`.
struct SrsTargets {
    double p[3][8], radius[8];
};

// upper_arm() on balls, for axis 4 perpendicular to `level`.
STEP UpperArm<Ball<Block>> upper_arm_in(const SrsArm& arm, const Vec<Ball<Block>>& p, const Vec<double>& level,
                                        const Ball<Block>& up) {
    using Number = Ball<Block>;
    const Number square = dot(p, p), reach = square - arm.along * arm.along, across = root(reach), over = 1.0 / root(square);
    const Number kappa = arm.along * over, rho = across * over;
    const Vec<Number> d = over * p, L = {Number(level.x), Number(level.y), Number(level.z)};
    // Axis 4 is kappa d + rho ahead, with ahead = (k g + root(g^2 - k^2) (g x d)) / g^2, where g is the part of L across the line.
    const Number along = dot(d, L);
    const Vec<Number> g = L - along * d;
    const Number gg = dot(g, g), k = -(kappa * along / rho), one = 1.0 / gg;
    const Vec<Number> ahead = (k * one) * g + (root(gg - k * k) * one) * cross(g, d), beside = cross(d, ahead);
    const Elbow<Number> e = elbow(across, Number(0.0), arm.upper, arm.fore, -1.0, up);
    const Vec<Number> m = rho * d - kappa * ahead;
    const Turn<Number>& first = e.second;
    return {e.bend,
            {first.c * m + first.s * beside, first.s * m - first.c * beside, kappa * d + rho * ahead},
            e.margin,
            reach,
            Number(0.0)};
}

PART void include_branches(const SrsArm& arm, const Rot<double>& R, const SrsTargets& targets, const Vec<double>& level, int first,
                           SrsBoxes& to) {
    using Number = Ball<Block>;
    const Block turn = arm.written.tolerances.exact_structure;
    const Goal<Block> middle = spread<Block>({R, {0.0, 0.0, 0.0}});
    const Vec<Block> p = {load<Block>(targets.p[0] + first), load<Block>(targets.p[1] + first), load<Block>(targets.p[2] + first)};
    const Seen<Number> at = within({middle.R, p}, turn, load<Block>(targets.radius + first));
    const auto sign = [&](int bit) {
        Block of;
        for (int l = 0; l < BLOCK; ++l) of.set(l, (first + l) & bit ? -1.0 : 1.0);
        return Number(of);
    };
    const UpperArm<Number> elbow = upper_arm_in(arm, at.p, level, sign(2));
    const Turn<Number> t4 = fourth_turn(arm, elbow);
    const Twists above = twists_of(arm.shoulder), behind = twists_of(arm.wrist);
    const Rot<Number> S = shoulder_rotation(arm, elbow), W = wrist_rotation(arm, elbow, t4, at.R);
    const Bend<Number> shoulder = wrist_bend(S.z, above, sign(4)), wrist = wrist_bend(W.z, behind, sign(1));
    const WristTurns<Number> s = wrist_turns(S, shoulder.turn, above), w = wrist_turns(W, wrist.turn, behind);
    box({shoulder.margin, elbow.margin, wrist.margin},
        {s.first, shoulder.turn, unit(s.last.c, s.last.s), unit(elbow.bend.c, elbow.bend.s), w.first, wrist.turn,
         unit(w.last.c, w.last.s)},
        first, to);
}

// Offsets of the boxes' angles from the joints' values.
struct SrsOffsets {
    double by[7];
};
STEP SrsOffsets offsets_of(const SrsArm& arm) { return {{0.0, arm.shoulder.shift, 0.0, arm.zero_4, 0.0, arm.wrist.shift, 0.0}}; }
// The greatest angle of an arc's points from its centre [rad], by its chord: asin(x / 2) <= pi / 6 x for x <= 1.
STEP double half_of(double chord) { return 1.0472 * chord; }

// The targets for the joint vectors in the boxes that are not free: `seen` is the target of the arm as written in frame 1.
PART void narrow(const SrsArm& arm, const Vec<double>& seen, const SrsBoxes& boxes, SrsTargets& to) {
    const SrsOffsets offset = offsets_of(arm);
    for (int first = 0; first < 8; first += BLOCK) {
        Turn<Block> turn[7];
        Block radius = load<Block>(to.radius + first), wide = 0.0;
        double rest = 0.0, length[7];
        for (int j = 6; j >= 0; --j) {
            const double* e = arm.off[j];
            length[j] = sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]);
            turn[j] = {load<Block>(boxes.c[j] + first), load<Block>(boxes.s[j] + first)};
            unturn(turn[j].c, turn[j].s, exact_turn(offset.by[j]));
            wide += (1.0472 * (length[j] + 2.0 * rest)) * load<Block>(boxes.chord[j] + first);
            rest += length[j];
        }
        Frame<Block> joint[7];
        joints_and_tip(arm.written, turn, joint);
        Vec<Block> shift = {Block(0.0), Block(0.0), Block(0.0)};
        for (int k = 0; k < 7; ++k) {
            const double* e = arm.off[k];
            const Rot<Block> after = turned(joint[k], turn[k]).R;
            shift = shift + (combine(joint[k].R, e[0], e[1], e[2]) - combine(after, e[0], e[1], e[2]));
        }
        shift = times(arm.ideal.base_rotation, shift);
        wide += ROUNDED * 100.0 * rest;
        const Block by[3] = {seen.x + shift.x, seen.y + shift.y, seen.z + shift.z};
        for (int l = 0; l < BLOCK; ++l) {
            const int b = first + l;
            if (boxes.free >> b & 1 || !(wide[l] < radius[l])) continue;
            to.radius[b] = wide[l];
            for (int i = 0; i < 3; ++i) to.p[i][b] = by[i][l];
        }
    }
}

// Whether a solution is the only one of the arm as written in box b: the error f has second derivatives of at most C, so that
// f(q') = f(q) = 0 asks for |q' - q| >= 2 least / C, where `least` bounds the Jacobian's smallest singular value at q from below.
// Joints that move by d turn frames by at most sqrt(7) |d|: the second derivative of a rotation is at most 7 |d|^2, the vector of
// its skew part at most sqrt(3 / 2) times as long; that of a direction is as large, and of a place as many times as the links are
// long.
STEP bool is_alone(const SrsArm& arm, const SrsBoxes& boxes, int b, const double* q, double least) {
    const SrsOffsets offset = offsets_of(arm);
    double square = 0.0, length = 0.0;
    for (int j = 0; j < 7; ++j) {
        const Turn<double> at = cos_sin_of_any(q[j] + offset.by[j]);
        const double c = at.c - boxes.c[j][b], s = at.s - boxes.s[j][b], half = half_of(boxes.chord[j][b]);
        if (!(sqrt(c * c + s * s) <= half + NEARER_THAN_ROUNDING)) return false;
        const double* t = arm.written.step[j + 1].t;
        square += half * half, length += sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]) / arm.written.size;
    }
    return 7.0 * sqrt(length * length + 1.5 + 1.0) * sqrt(square) < least;
}

// The status by the boxes of one pose; least: bounds of the singular values, by column.
STEP Status decided(const SrsArm& arm, const SrsBoxes& boxes, const double (&least)[8], const Columns<7>& columns) {
    const unsigned there = ~boxes.empty & 255u;
    const bool exact = arm.imperfection == 0.0;
    // A singular solution on the curve of a box that leaves a joint free decides the status, whatever is open elsewhere.
    for (int b = 0; b < 8 && exact; ++b) {
        if (boxes.free & there & 1u << b && columns.valid(b) && columns.flags[b] & SINGULAR) return Status::continuum;
    }
    int found = 0;
    bool clustered = false;
    for (int b = 0; b < 8; ++b) {
        const unsigned bit = 1u << b;
        const bool valid = columns.valid(b);
        found += valid;
        if (there & bit ? bool(boxes.free & bit) : valid) return Status::incomplete;
        unsigned tiny = 0;
        for (int k = 0; k < 3 && there & bit; ++k) {
            if (!(boxes.open[k] & bit)) continue;
            if (!(boxes.tiny[k] & bit) || !exact) return Status::incomplete;
            tiny |= 4u >> k;
        }
        // Branches whose tiny roots have other signs may stand for this one, where they are not far apart behind a short lever arm.
        bool owned = valid || !(there & bit);
        for (unsigned c = 0; c < 8 && !boxes.wide(b); ++c) owned = owned || (!((c ^ unsigned(b)) & ~tiny) && columns.valid(int(c)));
        if (!owned || (valid && !exact && !is_alone(arm, boxes, b, columns.row(b), least[b]))) return Status::incomplete;
        clustered = clustered || tiny;
    }
    if (found != columns.count()) return Status::incomplete;
    return clustered ? Status::clustered : Status::complete;
}

// The status of one pose at one swivel angle, whose solutions are in the columns, each in that of its branch.
inline Status Srs::status(const SrsArm& arm, const Goal<double>& goal, const Seen<double>& seen, double value,
                          const Columns<7>& columns) {
    const double far = arm.written.size + sqrt(dot(seen.p, seen.p));
    const Swivelled<double> swivel = swivelled(line_to_wrist(seen.p), cos_sin_of_any(value));
    double radius = arm.written.tolerances.exact_structure * far;
    for (const auto& e : arm.off) radius += 2.0 * sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]);
    SrsTargets targets;
    for (int b = 0; b < 8; ++b) {
        targets.p[0][b] = seen.p.x, targets.p[1][b] = seen.p.y, targets.p[2][b] = seen.p.z, targets.radius[b] = radius;
    }
    const bool exact = arm.imperfection == 0.0;
    double least[8] = {};
    for (int first = 0; first < 8 && !exact; first += BLOCK) {
        Block q[7];
        const unsigned lanes = solutions_in(columns, first, q);
        const Block bound = polish_block<true>(at_swivel(arm, swivel), spread<Block>(goal), q, {0, 0.0, 0}).least;
        store(select(mask_of(lanes), bound, Block(0.0)), least + first);
    }
    SrsBoxes boxes;
    Status status = Status::incomplete;
    for (int pass = 0; pass < (exact ? 1 : BOX_SRS_PASSES) && status == Status::incomplete; ++pass) {
        if (pass) narrow(arm, seen.p, boxes, targets);
        for (int k = 0; k < 3; ++k) boxes.open[k] = boxes.tiny[k] = 0;
        boxes.free = 0;
        for (int first = 0; first < 8; first += BLOCK) include_branches(arm, seen.R, targets, swivel.level, first, boxes);
        status = decided(arm, boxes, least, columns);
    }
    return status;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
