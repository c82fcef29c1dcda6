// Interval inclusion through a closed form: boxes that hold every real solution of a pose.
//
// The ideal arm's closed form runs on balls (arithmetic/ball.hpp) that hold every target of a set: all targets D T, where D is any
// displacement between the ideal arm and the arm as written, rounding included. Each branch takes one sign of every root, so each
// gives one box: an arc for every joint. A margin below zero in the whole ball empties the box. Each real solution of the arm as
// written is a solution of the ideal arm for one of these targets, so it lies in a box:
//   empty   no solution
//   sure    every margin is above zero and every lever arm above its error: there is a solution for every target, which moves
//           continuously with the target. If D is the same for all joint vectors, as it is up to rounding for an exact arm, the
//           box holds exactly one solution, since the signs of the roots tell the branches apart
//   free    a lever arm does not exceed its error: a joint's arc is the whole circle
//   other   a margin may have either sign: two solutions, one double root or none
#pragma once

#include "answers/answer.hpp"
#include "answers/branch.hpp"
#include "arithmetic/ball.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Rounding that every target's ball holds [rad, share of size]: what Newton's method leaves of the error of a solution that is
// returned; twelve operations on each number of a target in to_frame_1(); and the rounding of seven rotations whose cosines and
// sines are rounded (two each).
inline constexpr double TARGET_ROUNDING = CONVERGED + 26.0 * ROUNDED;
// Solutions closer to each other than this [rad] stand as one: the pose error half way between them is about an eighth of the
// square, 1e-13, which rounding can make of a solution next to a double root.
inline constexpr double NEARER_THAN_ROUNDING = 1e-6;

// The boxes of one pose, by branch: centres and chords of the arcs of the joints' angles, offsets included. A whole circle has its
// centre at the origin and a chord of 1.
struct Boxes {
    double c[6][8], s[6][8], chord[6][8];
    unsigned empty = 0, sure = 0, free = 0;
};

// The boxes of a block of branches from `first` on, each for targets within `turn` [rad] and `shift` [m] of its own.
template <class Family>
PART void include(const typename Family::Arm& arm, const Seen<Block>& target, const Block& turn, const Block& shift, int first,
                  Boxes& to) {
    using Number = Ball<Block>;
    const auto within = [](const Vec<Block>& a, const Block& radius) {
        return Vec<Number>{{a.x, radius}, {a.y, radius}, {a.z, radius}};
    };
    const Seen<Number> seen = {{within(target.R.x, turn), within(target.R.y, turn), within(target.R.z, turn)},
                               within(target.p, shift)};
    const Branch<Number> at = branches_from<Family, Number>(arm, seen, first);
    const auto below = [](const Number& margin) { return margin.greatest() < Block(0.0); };
    const auto above = [](const Number& margin) { return margin.least() > Block(0.0); };
    to.empty |= bits(below(at.shoulder) | below(at.elbow) | below(at.wrist)) << first;
    to.sure |= bits(above(at.shoulder) & above(at.elbow) & above(at.wrist)) << first;
    for (int j = 0; j < 6; ++j) {
        const Turn<Number>& t = at.turn[j];
        store(t.c.mid, to.c[j] + first), store(t.s.mid, to.s[j] + first), store(t.c.rad, to.chord[j] + first);
        to.free |= bits(!(t.c.mid * t.c.mid + t.s.mid * t.s.mid > Block(0.5))) << first;
    }
}

// How far a joint vector (its joints' angles, offsets included) is from the boxes, by branch: the greatest distance of a joint's
// point on the circle from the centre of its arc, and whether every joint lies in its arc, or within `slack` of it.
struct Near {
    double distance[8];
    unsigned inside = 0;
};
PART Near near_boxes(const Boxes& boxes, const double (&angles)[6], double slack) {
    Near out;
    for (int first = 0; first < 8; first += BLOCK) {
        Block most = 0.0, beyond = -1.0;
        for (int j = 0; j < 6; ++j) {
            const Turn<double> at = exact_turn(angles[j]);
            const Block c = load<Block>(boxes.c[j] + first) - at.c, s = load<Block>(boxes.s[j] + first) - at.s;
            const Block away = root(c * c + s * s);
            most = max(most, away), beyond = max(beyond, away - load<Block>(boxes.chord[j] + first));
        }
        store(most, out.distance + first);
        out.inside |= bits(beyond <= Block(slack)) << first;
    }
    return out;
}

// The status of an exact arm's pose: every box is empty, holds one solution of its own, or is so small and so near to a solution
// that those that it may hold stand as one with it.
template <class Arm> PART Status status_of(const Arm& arm, const Boxes& boxes, const Columns<6>& columns) {
    unsigned owned = 0, met = 0, clustered = 0, used = 0;  // by branch; by column
    double widest[8] = {};
    for (int b = 0; b < 8; ++b) {
        for (int j = 0; j < 6; ++j) widest[b] = max(widest[b], boxes.chord[j][b]);
    }
    const unsigned open = ~boxes.empty & 255u;
    for (int k = 0; k < columns.many; ++k) {
        if (!columns.valid(k)) continue;
        double angles[6];
        for (int j = 0; j < 6; ++j) angles[j] = columns.row(k)[j] + arm.ideal.offset[j];
        const Near near = near_boxes(boxes, angles, arm.written.tolerances.duplicate);
        const unsigned in = near.inside & open;
        if (!in) return Status::incomplete;
        met |= in;
        const unsigned alone = in & boxes.sure & ~boxes.free & ~owned;
        owned |= alone & -alone;  // one column owns one box
        for (int b = 0; b < 8; ++b) clustered |= unsigned(near.distance[b] + widest[b] <= NEARER_THAN_ROUNDING) << b;
    }
    (void)used;
    const unsigned left = open & ~owned;
    if (left & ~(clustered | (boxes.free & met))) return Status::incomplete;
    if (left & ~clustered) return Status::continuum;
    return left ? Status::clustered : Status::complete;
}

// The status of one pose of an exact arm whose solutions are in the columns; seen: its target, whose rotation is a rotation.
template <class Family>
PART Status status_by_inclusion(const typename Family::Arm& arm, const Seen<double>& seen, const Columns<6>& columns) {
    const auto wide = [](const Vec<double>& a) { return Vec<Block>{Block(a.x), Block(a.y), Block(a.z)}; };
    const Seen<Block> target = {{wide(seen.R.x), wide(seen.R.y), wide(seen.R.z)}, wide(seen.p)};
    const double far = arm.ideal.size + abs(seen.p.x) + abs(seen.p.y) + abs(seen.p.z);
    Boxes boxes;
    for (int first = 0; first < 8; first += BLOCK) {
        include<Family>(arm, target, arm.ideal.budget.turn[0] + TARGET_ROUNDING, arm.ideal.budget.shift[0] + TARGET_ROUNDING * far,
                        first, boxes);
    }
    return status_of(arm, boxes, columns);
}

}  // namespace urdf_ik::URDF_IK_LEVEL
