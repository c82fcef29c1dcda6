// See certified.hpp. Compiled once for every instruction set.
#include "families/imperfect/certified.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// How often boxes are made from smaller sets of displacements before a pose is left open, and the share of its width that a box
// has to lose to be worth one more.
inline constexpr int PASSES = 16;
inline constexpr double WORTH_A_PASS = 0.1;
// Both arms' tips follow from seven frames each: twice as many operations as a target takes.
inline constexpr double CORRECTION_ROUNDING = 4.0 * ROUNDING;

// A block of boxes: half the width of its widest arc [rad], infinite for a whole circle, and its centre as joint values.
struct Middle {
    Block q[6], width;
};
STEP Middle middle_of(const Boxes& boxes, const IdealFrames& ideal, int first) {
    Middle out;
    out.width = 0.0;
    for (int j = 0; j < 6; ++j) {
        const Block c = load<Block>(boxes.c[j] + first), s = load<Block>(boxes.s[j] + first),
                    x = load<Block>(boxes.chord[j] + first);
        out.q[j] = wrap(atan2(s, c) - ideal.offset[j]);
        out.width = max(out.width, select(c * c + s * s > Block(0.5), half_angle(x), Block(__builtin_inf())));
    }
    return out;
}

// Targets of the ideal arm for a block of boxes: within `turn` and `shift` of the middle.
struct Targets {
    Seen<Block> middle;
    Block turn, shift;
};
// The targets for the joint vectors within `half` of `turn`. chord: of half of the arcs; a whole circle has a chord of 2. apart:
// bounds on the displacements X below.
//
// X is the displacement between the two arms of all that joint j carries: by the angle turn_j, and the length shift_j at the tip.
// Turning joint j by R, with a chord x, replaces X by R X R^-1. So the target turns by at most turn_j x, and shifts by at most
// (shift_j + turn_j (length_j + 2 e)) x: a point that is e from the tip of the arm as written is at most length_j + e from joint j,
// and X shifts it by at most shift_j + turn_j e.
//
// In a small box the first derivatives at its middle say more. D = I W^-1 changes with joint j like a motion with the angular
// velocity z_j - D z'_j, where z_j and z'_j are the joint's axes in both arms, and moves the target's point by the difference of
// the velocities that both axes give to it. The second derivative by joints i <= j turns X by one more axis: at most turn_j, and
// shift_j + turn_j (length_i + length_j + 3 e) for a point.
PART Targets targets_of(const BothArms& arm, const Displacement& apart, const Goal<Block>& goal, const Turn<Block> (&turn)[6],
                        const Block (&chord)[6], const Block (&half)[6]) {
    Block turned = CORRECTION_ROUNDING;
    for (int j = 0; j < 6; ++j) turned += apart.turn[j + 1] * chord[j];
    Frame<Block> joint_W[6], joint_I[6];
    const Frame<Block> W = joints_and_tip(arm.written, turn, joint_W), I = joints_and_tip(arm.ideal, turn, joint_I);
    const auto through = [&](const Vec<Block>& a) { return I.R * Vec<Block>{dot(W.R.x, a), dot(W.R.y, a), dot(W.R.z, a)}; };
    const Vec<Block> off = goal.p - W.p;
    Block reach = root(dot(off, off)), shifted = CORRECTION_ROUNDING * (2.0 * apart.length[0] + root(dot(goal.p, goal.p)));
    for (int j = 0; j < 6; ++j) reach += apart.length[j + 1] * chord[j];
    Block turned_once = CORRECTION_ROUNDING, shifted_once = shifted;
    for (int j = 0; j < 6; ++j) {
        shifted += (apart.shift[j + 1] + apart.turn[j + 1] * (apart.length[j + 1] + 2.0 * reach)) * chord[j];
    }
    const Seen<Block> middle = {each(goal.R, through), I.p + through(off)};
    Block before = 0.0, lever = 0.0;  // of the joints up to j: sums of half, and of half times length
    for (int j = 0; j < 6; ++j) {
        const Vec<Block>&z = joint_I[j].R.z, &other = joint_W[j].R.z;
        const Vec<Block> w = z - through(other);
        const Vec<Block> v = cross(z, middle.p - joint_I[j].p) - through(cross(other, goal.p - joint_W[j].p));
        const double t = apart.turn[j + 1], l = apart.length[j + 1];
        // Pairs of joints up to j: each pair of different ones counts twice, with the half of Taylor's formula once.
        const Block pairs = half[j] * (before + 0.5 * half[j]), levers = half[j] * (lever + l * before + l * half[j]);
        turned_once += half[j] * (root(dot(w, w)) + CORRECTION_ROUNDING) + t * pairs;
        shifted_once += half[j] * (root(dot(v, v)) + CORRECTION_ROUNDING * (l + reach)) +
                        (apart.shift[j + 1] + 3.0 * t * reach) * pairs + t * levers;
        before += half[j], lever += half[j] * l;
    }
    const auto crude = !((turned_once < turned) & (shifted_once < shifted));
    return {middle, INFLATED * select(crude, turned, turned_once), INFLATED * select(crude, shifted, shifted_once)};
}

// The next pass for a block of boxes, from the displacements of the joint vectors in each box. Returns whether one is worth more.
PART bool narrow(const BothArms& arm, const Displacement& apart, const Goal<Block>& goal, const Inclusion& family, int first,
                 Boxes& boxes, unsigned& open) {
    Turn<Block> turn[6];
    Block chord[6], half[6], total = 0.0;
    for (int j = 0; j < 6; ++j) {
        const Block c = load<Block>(boxes.c[j] + first), s = load<Block>(boxes.s[j] + first);
        const auto arc = c * c + s * s > Block(0.5);
        turn[j] = {select(arc, c, Block(1.0)), select(arc, s, Block(0.0))};
        chord[j] = select(arc, load<Block>(boxes.chord[j] + first), Block(2.0)), half[j] = half_angle(chord[j]);
        total += chord[j];
    }
    const Targets targets = targets_of(arm, apart, goal, turn, chord, half);
    Boxes next;
    family.include(family.arm, targets.middle, targets.turn, targets.shift, first, next);
    Block left = 0.0;
    for (int j = 0; j < 6; ++j) {
        const Block c = load<Block>(next.c[j] + first), s = load<Block>(next.s[j] + first);
        left += select(c * c + s * s > Block(0.5), load<Block>(next.chord[j] + first), Block(2.0));
    }
    const unsigned smaller = bits(left < total) << first;
    open &= ~next.empty;
    for (int b = first; b < first + BLOCK; ++b) {
        if (!(smaller >> b & 1)) continue;
        for (int j = 0; j < 6; ++j)
            boxes.c[j][b] = next.c[j][b], boxes.s[j][b] = next.s[j][b], boxes.chord[j][b] = next.chord[j][b];
    }
    return bits(left < (1.0 - WORTH_A_PASS) * total) << first & open;
}

// A certified root from the middle of each box, for a block of boxes.
struct Rooted {
    Block q[6], radius;  // joint values; there is no other root within radius
    unsigned found;
};
// middle, half: of each box; only lanes in `wanted` are computed.
PART Rooted root_of(const Loop& loop, const Block (&middle)[6], const Block& half, unsigned wanted) {
    // The other lanes repeat a box, so that they cost nothing more.
    const int one = __builtin_ctz(wanted);
    Rooted out;
    Block(&q)[6] = out.q;
    Block width = half;
    for (int j = 0; j < 6; ++j) q[j] = middle[j];
    for (int l = 0; l < BLOCK; ++l) {
        if (wanted >> l & 1) continue;
        width.set(l, half[one]);
        for (int j = 0; j < 6; ++j) q[j].set(l, middle[j][one]);
    }
    Turn<Block> turn[6];
    Orthogonal<Block> factors;
    LoopAt<Block> at;
    // One step leads to where a root is certified, and one more, with the same factors, to the solution. From a wide box that does
    // not converge: the box waits for the next pass.
    const auto step = [&] {
        const Six<Block> x = newton_step(factors, at.error);
        Block longest = 0.0;
        for (int j = 0; j < 6; ++j) q[j] = wrap(q[j] + x[j]), longest = max(longest, abs(x[j]));
        return longest;
    };
    linearise(loop, q, at, factors);
    const Block holding = INFLATED * (width + step());
    turns_of(q, turn);
    at = loop_at(loop, turn);
    const Certificate root = certify(loop, at, factors, growth_of(q), holding);
    out.radius = root.outer - INFLATED * step() - 8.0 * UNIT;
    turns_of(q, turn);
    const auto converged = largest(loop_at(loop, turn).error) <= Block(CONVERGED);
    out.found = wanted & bits(root.holds & (root.outer >= holding) & converged);
    return out;
}

PART void certify_boxes(const IdealFrames& ideal, const Loop& loop, const Boxes& boxes, int first, Known& known,
                        double (&radii)[8]) {
    constexpr unsigned all = (1u << BLOCK) - 1;
    const Middle box = middle_of(boxes, ideal, first);
    const unsigned open = known.open >> first & all & bits(box.width <= Block(WIDEST_BOX));
    if (!open) return;
    const Rooted root = root_of(loop, box.q, box.width, open);
    known.found |= root.found << first, known.open &= ~(root.found << first);
    for (int l = 0; l < BLOCK; ++l) {
        if (!(root.found >> l & 1)) continue;
        radii[first + l] = root.radius[l];
        for (int j = 0; j < 6; ++j) known.angle[j][first + l] = root.q[j][l] + ideal.offset[j];
    }
}

void certify_all(const Written<6>& written, const BothArms& both, const IdealFrames& ideal, const Goal<double>& goal,
                 const Seen<double>& seen, const Inclusion& family, Known& known) {
    const Goal<Block> target = spread<Block>(seen);
    const Displacement& apart = ideal.displacement;
    const double far = ideal.size + sqrt(dot(seen.p, seen.p));
    const Loop loop = loop_of(written, goal);
    Boxes boxes;
    double radii[8];
    bool narrows = true;
    for (int pass = 1; pass <= PASSES && known.open && narrows; ++pass) {
        narrows = pass == 1;
        for (int first = 0; first < 8; first += BLOCK) {
            if (!(known.open >> first & ((1u << BLOCK) - 1))) continue;
            if (pass == 1) {
                family.include(family.arm, target, apart.turn[0] + ROUNDING, apart.shift[0] + ROUNDING * far, first, boxes);
                known.open &= ~boxes.empty;
            } else {
                narrows |= narrow(both, apart, target, family, first, boxes, known.open);
            }
            certify_boxes(ideal, loop, boxes, first, known, radii);
        }
    }
    // Roots of which one lies within the radius of the other are the same.
    for (int b = 0; b < 8; ++b) {
        for (int first = 0; first < b; first += BLOCK) {
            Block most = 0.0;
            for (int j = 0; j < 6; ++j) most = max(most, abs(wrap(wrap(known.angle[j][b] - load<Block>(known.angle[j] + first)))));
            const unsigned same = bits(most <= max(load<Block>(radii + first), radii[b])) << first;
            if (same & known.found & ((1u << b) - 1)) known.found &= ~(1u << b);
        }
    }
}

}  // namespace urdf_ik::URDF_IK_LEVEL
