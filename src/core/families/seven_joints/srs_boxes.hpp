// Interval inclusion at a swivel angle: boxes that hold every solution of an S-R-S arm, as in answers/inclusion.hpp.
//
// The ideal arm has the axes' directions of the arm as written, and its tip is at most SrsArm::apart away at the same joint vector.
// So the closed form runs on balls that hold all targets so far away. Axis 4 keeps its direction, to which the target's swivel
// angle refers: a target d away turns line and normal by d, and their swivel angle by asin(d kappa / rho) + d at most, where kappa
// and rho are axis 4's cosine and sine against the line.
#pragma once

#include "answers/inclusion.hpp"
#include "families/seven_joints/srs.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The boxes of the eight branches: centres and chords of the joints' arcs, as in Boxes; joints 2, 4 and 6 with their offsets.
struct SrsBoxes {
    double c[7][8], s[7][8], chord[7][8];
    // By margin (shoulder, elbow, wrist; their roots have bits 4, 2 and 1 of a branch's number).
    unsigned open[3] = {}, tiny[3] = {}, empty = 0, free = 0;
};

// line_to_wrist() on balls. on: whether the wrist counts as lying on axis 1.
STEP Line<Ball<Block>> line_of(const Vec<Ball<Block>>& p, bool on) {
    using Number = Ball<Block>;
    const Number length = root(p.x * p.x + p.y * p.y + p.z * p.z), over = 1.0 / length;
    const Vec<Number> d = over * p;
    Vec<Number> n;
    if (on) {
        const Number u = 1.0 / root(1.0 - d.x * d.x);
        n = {(1.0 - d.x * d.x) * u, -(d.x * d.y * u), -(d.x * d.z * u)};
    } else {
        const Turn<Number> t = unit(p.x, p.y);
        n = {-t.s, t.c, Number(0.0)};
    }
    return {d, n, cross(d, n), length};
}

// upper_arm() on balls.
STEP UpperArm<Ball<Block>> upper_arm_in(const SrsArm& arm, const Line<Ball<Block>>& line, const Turn<double>& swivel,
                                        const Ball<Block>& up) {
    using Number = Ball<Block>;
    const Number reach = line.length * line.length - arm.along * arm.along, over = 1.0 / line.length;
    const Number across = root(reach), kappa = arm.along * over, rho = across * over;
    const auto wide = [](const Vec<Number>& v) { return max(v.x.rad, max(v.y.rad, v.z.rad)); };
    const Block d =
        2.0 * max(wide(line.along), max(wide(line.normal), wide(line.across)));  // of vectors whose entries are so far off
    const Block slope = abs(kappa.mid) + kappa.rad, least = rho.least();
    const Block off = select(least > slope * d, 1.6 * d * slope / least + d, Block(2.0));
    const Turn<Number> at = {{Block(swivel.c), off}, {Block(swivel.s), off}};
    const Vec<Number> ahead = at.c * line.normal + at.s * line.across, level = at.c * line.across - at.s * line.normal;
    const Elbow<Number> e = elbow(across, Number(0.0), arm.upper, arm.fore, -1.0, up);
    const Vec<Number> m = rho * line.along - kappa * ahead;
    const Turn<Number>& first = e.second;
    return {e.bend,
            {first.c * m + first.s * level, first.s * m - first.c * level, kappa * line.along + rho * ahead},
            e.margin,
            reach,
            Number(0.0)};
}

PART void include_branches(const SrsArm& arm, const Seen<double>& seen, double value, int first, SrsBoxes& to) {
    using Number = Ball<Block>;
    const double far = arm.written.size + sqrt(dot(seen.p, seen.p)), turn = arm.written.tolerances.exact_structure;
    const Goal<Block> middle = spread<Block>({seen.R, seen.p});
    const Seen<Number> at = within({middle.R, middle.p}, Block(turn), Block(arm.apart + turn * far));
    const double aside = sqrt(seen.p.x * seen.p.x + seen.p.y * seen.p.y);
    const Line<Number> line = line_of(at.p, aside <= ON_AXIS * sqrt(dot(seen.p, seen.p)));
    const auto sign = [&](int bit) {
        Block of;
        for (int l = 0; l < BLOCK; ++l) of.set(l, (first + l) & bit ? -1.0 : 1.0);
        return Number(of);
    };
    const UpperArm<Number> elbow = upper_arm_in(arm, line, cos_sin_of_any(value), sign(2));
    const Turn<Number> t4 = fourth_turn(arm, elbow);
    const Twists above = twists_of(arm.shoulder), behind = twists_of(arm.wrist);
    const Rot<Number> S = shoulder_rotation(arm, elbow), W = wrist_rotation(arm, elbow, t4, at.R);
    const Bend<Number> shoulder = wrist_bend(S.z, above, sign(4)), wrist = wrist_bend(W.z, behind, sign(1));
    const WristTurns<Number> s = wrist_turns(S, shoulder.turn, above), w = wrist_turns(W, wrist.turn, behind);
    const Number* margins[3] = {&shoulder.margin, &elbow.margin, &wrist.margin};
    for (int k = 0; k < 3; ++k) {
        const unsigned all = (1u << BLOCK) - 1;
        to.empty |= bits(margins[k]->greatest() < Block(-EMPTY_MARGIN)) << first;
        to.open[k] |= (~bits(margins[k]->least() > Block(0.0)) & all) << first;
        to.tiny[k] |= bits(margins[k]->greatest() <= Block(TINY_MARGIN)) << first;
    }
    const Turn<Number> turns[7] = {s.first, shoulder.turn, unit(s.last.c, s.last.s), elbow.bend,
                                   w.first, wrist.turn,    unit(w.last.c, w.last.s)};
    for (int j = 0; j < 7; ++j) {
        const Turn<Number>& t = turns[j];
        store(t.c.mid, to.c[j] + first), store(t.s.mid, to.s[j] + first), store(t.c.rad, to.chord[j] + first);
        to.free |= bits(!(t.c.mid * t.c.mid + t.s.mid * t.s.mid > Block(0.5))) << first;
    }
}

// Whether the solution q is the only one of the arm as written in box b: f has second derivatives of at most C, so f(q') = f(q) = 0
// asks for |q' - q| >= 2 least / C, where `least` is the Jacobian's smallest singular value at q.
PART bool is_alone(const SrsArm& arm, const AtSwivel& model, const Goal<double>& goal, const SrsBoxes& boxes, int b,
                   const double (&q)[7]) {
    const double offset[7] = {0.0, arm.shoulder.shift, 0.0, arm.zero_4, 0.0, arm.wrist.shift, 0.0};
    double square = 0.0, length = 0.0;
    for (int j = 0; j < 7; ++j) {
        const Turn<double> at = cos_sin_of_any(q[j] + offset[j]);
        const double c = at.c - boxes.c[j][b], s = at.s - boxes.s[j][b], chord = boxes.chord[j][b];
        if (!(sqrt(c * c + s * s) <= chord + NEARER_THAN_ROUNDING)) return false;
        square += 1.1 * chord * chord;  // the arc of a chord of at most 1 is at most pi / 3 times as long
        const double* t = arm.written.step[j + 1].t;
        length += sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]) / arm.written.size;
    }
    // Joints that move by d turn frames by at most sqrt(7) |d|: the second derivative of a rotation is at most 7 |d|^2, its skew
    // part's vector sqrt(3 / 2) of it; of a direction as much as of a rotation, of a place `length` times as much.
    const double C = 7.0 * sqrt(length * length + 1.5 + 1.0);
    return C * sqrt(square) < weakest_at(model, goal, q).value;
}

// The status of one pose at one swivel angle, whose solutions are in the columns, each in that of its branch.
inline Status Srs::status(const SrsArm& arm, const Goal<double>& goal, const Seen<double>& seen, double value,
                          const Columns<7>& columns) {
    const double far = sqrt(dot(seen.p, seen.p)), aside = sqrt(seen.p.x * seen.p.x + seen.p.y * seen.p.y);
    // Another formula may hold for some of the targets.
    const double slack = arm.apart + arm.written.tolerances.exact_structure * (arm.written.size + far);
    if (abs(aside - ON_AXIS * far) <= slack) return Status::incomplete;
    SrsBoxes boxes;
    for (int first = 0; first < 8; first += BLOCK) include_branches(arm, seen, value, first, boxes);
    const AtSwivel model = at_swivel(arm, swivelled(line_to_wrist(seen.p), cos_sin_of_any(value)));
    const unsigned there = ~boxes.empty & 255u;
    // A singular solution on the curve of a box that leaves a joint free decides the status, whatever is open elsewhere.
    for (int b = 0; b < 8 && arm.imperfection == 0.0; ++b) {
        if (boxes.free & there & 1u << b && columns.valid(b) && columns.flags[b] & SINGULAR) return Status::continuum;
    }
    int found = 0;
    bool clustered = false;
    for (int b = 0; b < 8; ++b) {
        const unsigned bit = 1u << b;
        const bool valid = columns.valid(b);
        found += valid;
        if (!(there & bit)) {
            if (valid) return Status::incomplete;
            continue;
        }
        if (boxes.free & bit) return Status::incomplete;
        unsigned tiny = 0;
        for (int k = 0; k < 3; ++k) {
            if (!(boxes.open[k] & bit)) continue;
            if (!(boxes.tiny[k] & bit) || arm.imperfection > 0.0) return Status::incomplete;
            tiny |= 4u >> k;
        }
        // Branches whose tiny roots have other signs may stand for this one.
        bool owned = valid;
        for (unsigned c = 0; c < 8; ++c) owned = owned || (!((c ^ unsigned(b)) & ~tiny) && columns.valid(int(c)));
        if (!owned) return Status::incomplete;
        clustered = clustered || tiny;
        if (arm.imperfection == 0.0) continue;
        double q[7];
        for (int j = 0; j < 7; ++j) q[j] = columns.row(b)[j];
        if (!is_alone(arm, model, goal, boxes, b, q)) return Status::incomplete;
    }
    if (found != columns.count()) return Status::incomplete;
    return clustered ? Status::clustered : Status::complete;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
