// Interval inclusion through a closed form: boxes that hold every real solution of a pose.
//
// The ideal arm's closed form runs on balls (numbers/ball.hpp) that hold every target of a set: all targets D T, where D is any
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

#include "numbers/ball.hpp"
#include "propose/proposals.hpp"
#include "referee/on_curve.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Two solutions that differ in the sign of a root stand as one if the root's square is below TINY_MARGIN, and two joint vectors if
// each joint's angles are closer than NEARER_THAN_ROUNDING [rad]. Half way between them, where the root is zero, the pose error is
// about the margin, or an eighth of the squared distance: what lies there would be verified as a solution too
// (Tolerances::reach, 1e-10).
inline constexpr double TINY_MARGIN = 1e-11;
inline constexpr double NEARER_THAN_ROUNDING = 1e-5;
// A margin empties a box only if it is below -EMPTY_MARGIN. Two roots that are not real, but whose margin is above, keep the pose
// to about the margin at their real part: Tolerances::reach would verify it, and another rounding of the pose would make them real.
// Their box stays, and without a solution in it nothing is proven.
inline constexpr double EMPTY_MARGIN = 1e-10;

// Branches from `first` on, one per lane, each for its own target; `of`: the signs of their roots.
template <class Family, class V>
STEP Branch<V> branches_from(const typename Family::Arm& arm, const Seen<V>& seen, int first, const double (&of)[3][8]) {
    const auto signs = [&](int k) { return V(load<Block>(of[k] + first)); };
    Branch<V> out;
    if constexpr (requires { out.arms.rad; }) out = Family::template branch<V>(arm, seen, {signs(0), signs(1), signs(2)});
    else branch_of_lanes<Family>(arm, seen, {signs(0), signs(1), signs(2)}, out);
    return out;
}

// All targets within `turn` [rad] and `shift` [m] of these.
STEP Seen<Ball<Block>> within(const Seen<Block>& target, const Block& turn, const Block& shift) {
    const auto wide = [](const Vec<Block>& a, const Block& radius) {
        return Vec<Ball<Block>>{{a.x, radius}, {a.y, radius}, {a.z, radius}};
    };
    return {{wide(target.R.x, turn), wide(target.R.y, turn), wide(target.R.z, turn)}, wide(target.p, shift)};
}

// Half the angle of an arc with a chord x, or more: 2 asin(x / 2) <= x (1 + 0.056 x^2), up to a half circle, where x^2 = 2.
template <class V> STEP V half_angle(const V& x) { return select(x * x <= V(2.0), x + 0.056 * x * x * x, V(PI)); }

// The boxes of one pose, by branch: centres and chords of the arcs of the joints' angles, offsets included. A whole circle has its
// centre at the origin and a chord of 1.
template <int N> struct BoxesOf {
    double c[N][8], s[N][8], chord[N][8];
    // By margin (shoulder, elbow, wrist): it may have either sign, it is at most TINY_MARGIN.
    unsigned open[3] = {}, tiny[3] = {}, empty = 0, free = 0;

    STEP unsigned sure() const { return ~(open[0] | open[1] | open[2]) & 255u; }
    STEP bool wide(int b) const {
        double most = 0.0;
        for (const auto& chords : chord) most = max(most, chords[b]);
        return !(most <= NEAR);
    }
};

using Boxes = BoxesOf<6>;

// The boxes of a block of branches from `first` on, by the margins of the shoulder, the elbow and the wrist, and the turns.
template <int N>
STEP void box(const Ball<Block> (&margin)[3], const Turn<Ball<Block>> (&turn)[N], int first, BoxesOf<N>& to) {
    for (int k = 0; k < 3; ++k) {
        const Block most = margin[k].greatest();
        const unsigned below = bits(most < Block(-EMPTY_MARGIN)), above = bits(margin[k].least() > Block(0.0));
        to.empty |= below << first, to.open[k] |= (~above & ((1u << BLOCK) - 1)) << first;
        to.tiny[k] |= bits(most <= Block(TINY_MARGIN)) << first;
    }
    for (int j = 0; j < N; ++j) {
        const auto& [c, s] = turn[j];
        store(c.mid, to.c[j] + first), store(s.mid, to.s[j] + first), store(c.rad, to.chord[j] + first);
        to.free |= bits(!(c.mid * c.mid + s.mid * s.mid > Block(0.5))) << first;
    }
}
// Each for targets within `turn` [rad] and `shift` [m] of its own.
template <class Family>
PART void include(const typename Family::Arm& arm, const Seen<Block>& target, const Block& turn, const Block& shift, int first,
                  const double (&signs)[3][8], Boxes& to) {
    const auto at = branches_from<Family, Ball<Block>>(arm, within(target, turn, shift), first, signs);
    box({at.shoulder, at.elbow, at.wrist}, at.turn, first, to);
}

// What a pose's solutions tell of its boxes. A solution is in a box too if it is so near to it that what the box holds stands as
// one with it.
struct Filled {
    unsigned in[8] = {};  // by column: the boxes, by branch, that its solution lies in
    unsigned owned = 0, met = 0;  // the boxes with a solution of their own, and with a solution
    bool all = true;  // every solution lies in a box
};
Filled filled_by(const IdealFrames& ideal, const Boxes& boxes, const Columns<6>& columns);

// The status of an exact arm's pose; the boxes in `counted` hold nothing but what the columns have. A box whose joints are all
// fixed holds at most one solution, since the signs of the roots tell the branches apart: a solution of its own decides it, up to
// the rounding of the pose where a root may have either sign. A box without one is decided if each of its open roots is tiny, and
// one of its twins, which differ from it in the signs of tiny roots alone, has a solution and is beside it. Behind a short lever
// arm twins are half a turn apart, and do not stand for each other.
Status decided(const IdealFrames& ideal, const Boxes& boxes, const Filled& filled, unsigned counted = 0);

// Whether nothing is left to be found: each box is empty, has a solution of its own, or leaves joints free and holds a solution at
// which all joints with wide arcs turn about one line. The pose fixes only the sum of these turns, so such a box holds no more than
// the curve of that solution.
bool is_settled(const Written<6>& arm, const Goal<double>& goal, const Boxes& boxes, const Filled& filled,
                const Columns<6>& columns);

// The boxes, by branch, that hold nothing but what the columns have since a solution is at their fold. A fold that keeps the pose
// to the tolerance is added to the columns where its box has no solution.
//
// Where an open root is zero, a box and its twin, which has the root's other sign, hold the same solution: the fold. `folds` are
// boxes of the folds: the closed form with zeros in place of the open roots. Behind a short lever arm, or another fold, an open
// margin is known to half of the digits or less, and the box is wide; the box of its fold is not, since the root is left out.
//
// Claim: the box holds no solution but the one in its fold's box, to the rounding of the pose. The fold's box is at most
// NEARER_THAN_ROUNDING wide. Proof: let s be a solution in the box.
//   - Each open margin is tiny at the fold: joint vectors that keep the pose to about these margins lead from s to the fold.
//   - One root is open, and a joint vector f in the fold's box keeps the pose to FINISHED: the fold itself, or a solution whose
//     other roots have the box's signs. Let the target move from the pose to the one that f reaches exactly, and s with it. Then s
//     meets its twin at a fold, or becomes the fold, or the twin of f, whose root is at most as large as the fold's box.
unsigned boxes_with_folds(const Written<6>& arm, const IdealFrames& ideal, const Goal<double>& goal, const Boxes& boxes,
                          const Boxes& folds, const Columns<6>& columns);

// The boxes of one pose of an exact arm, for all targets within `beyond` [rad, share of size] of it. Its rotation is a rotation.
template <class Family>
PART Boxes boxes_of(const typename Family::Arm& arm, const Goal<double>& goal, const double (&signs)[3][8], double beyond = 0.0) {
    const Seen<double> seen = to_frame_1(goal, arm.ideal);
    const Goal<Block> target = spread<Block>(seen);
    const Slack off = slack_of(arm.ideal, seen);
    Boxes out;
    for (int first = 0; first < 8; first += BLOCK) {
        include<Family>(arm, target, off.turn + beyond, off.shift + beyond * arm.ideal.size, first, signs, out);
    }
    return out;
}

// Fills the boxes by Newton's method from the branches in `wanted`. Returns the status that the boxes decide.
template <class Family>
PART Status fill(const typename Family::Arm& arm, const Goal<double>& goal, const Seen<double>& seen, const Quartic& roots,
                 const Reference<6>& reference, const Boxes& boxes, unsigned wanted, const Columns<6>& columns) {
    // The boxes of a quartic may be those of other branches, see rooted.hpp.
    constexpr bool rooted = has_quartic<Family>();
    const auto propose_from = [&](Attempt attempt) {
        return wanted ? propose<Family>(arm, goal, seen, roots, reference, attempt, wanted, columns) : Proposed{};
    };
    if (!rooted) wanted &= ~boxes.empty;
    const Proposed first = propose_from(double_roots);
    Filled filled;
    const auto status_now = [&] {
        filled = filled_by(arm.ideal, boxes, columns);
        // Next to a singularity a joint may only look free.
        if (first.fixed & boxes.free && !is_settled(arm.written, goal, boxes, filled, columns)) return Status::incomplete;
        return decided(arm.ideal, boxes, filled);
    };
    const Status status = status_now();
    const unsigned rest = (first.merged & ~filled.owned) | (boxes.free & ~filled.met);
    wanted &= rooted && rest ? 255u : rest;
    if (status != Status::incomplete || !wanted) return status;
    propose_from(both_roots);
    return status_now();
}

// Whether solutions may belong to a curve that keeps the pose to the tolerance of solutions, though boxes tell them apart.
STEP bool may_be_joined(const Boxes& boxes, Status status) {
    bool out = false;
    for (int b = 0; b < 8; ++b) out |= boxes.wide(b) && !(boxes.empty >> b & 1u);
    return out && status == Status::clustered;
}

// The status where the boxes alone leave it open: of a curve through a solution, or of folds.
template <class Family>
PART Status decided_closely(const typename Family::Arm& arm, const Goal<double>& goal, const Boxes& boxes,
                            const Columns<6>& columns) {
    if (any_is_on_curve(arm.written, goal, columns)) return Status::continuum;
    double signs[3][8];
    for (int k = 0; k < 3; ++k) {
        for (int b = 0; b < 8; ++b) signs[k][b] = boxes.open[k] >> b & 1u ? 0.0 : arm.ideal.signs[k][b];
    }
    // A joint vector whose pose error is computed as FINISHED, with as much rounding, has its own target in these boxes' set.
    const Boxes folds = boxes_of<Family>(arm, goal, signs, 2.0 * FINISHED);
    const unsigned folded = boxes_with_folds(arm.written, arm.ideal, goal, boxes, folds, columns);
    const Filled filled = filled_by(arm.ideal, boxes, columns);
    return decided(arm.ideal, boxes, filled, folded);
}

}  // namespace urdf_ik::URDF_IK_LEVEL
