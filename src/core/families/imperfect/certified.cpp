// See certified.hpp. Compiled once for every instruction set.
#include "families/imperfect/certified.hpp"

#include "certificate/single.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Half the width [rad] of the widest box from which a root can be shown to be alone: the norm of each joint's twist is at least
// sqrt(2), and S r in certificate/single.hpp at most LARGEST_BALL.
inline constexpr double WIDEST_BOX = LARGEST_BALL / (6.0 * 1.414);
// Newton's steps from the centre of a box to where a root is certified. One more, with the same factors, gives the solution; what a
// step leaves of a wide box fails to converge and waits for the next pass.
inline constexpr int STEPS = 1;

// How often boxes are made from smaller sets of displacements before a pose is left open.
inline constexpr int PASSES = 4;
// Both arms' tips follow from seven frames each: twice as many operations as a target takes.
inline constexpr double CORRECTION_ROUNDING = 4.0 * TARGET_ROUNDING;

// A block of boxes: half the width of its widest arc [rad], infinite for a whole circle, and its centre as joint values. An arc's
// chord x belongs to the angle 2 asin(x / 2) <= x (1 + 0.056 x^2), up to a half circle, where x^2 = 2.
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
        out.width = max(out.width, select(c * c + s * s > Block(0.5), x + 0.056 * x * x * x, Block(__builtin_inf())));
    }
    return out;
}

// The next pass for a block of boxes, from the displacements of the joint vectors in each box. Turning joint j by an angle of chord
// x replaces the displacement X of what joint j carries by one that has been turned with the joint. So the target turns by at most
// turn_j x, and shifts by at most (shift_j + turn_j (length_j + 2 e)) x: a point that is e from the tip of the arm as written is at
// most length_j + e from joint j, and X shifts it by at most shift_j + turn_j e.
PART void narrow(const BothArms& arm, const Displacement& apart, const Goal<Block>& goal, const Inclusion& family, int first,
                 Boxes& boxes, unsigned& open) {
    Turn<Block> turn[6];
    Block chord[6], turned = CORRECTION_ROUNDING, total = 0.0;
    for (int j = 0; j < 6; ++j) {
        const Block c = load<Block>(boxes.c[j] + first), s = load<Block>(boxes.s[j] + first);
        const auto arc = c * c + s * s > Block(0.5);
        turn[j] = {select(arc, c, Block(1.0)), select(arc, s, Block(0.0))};
        chord[j] = select(arc, load<Block>(boxes.chord[j] + first), Block(2.0));
        turned += apart.turn[j + 1] * chord[j], total += chord[j];
    }
    const Frame<Block> W = tip_after(arm.written, turn), I = tip_after(arm.ideal, turn);
    const auto through = [&](const Vec<Block>& a) { return I.R * Vec<Block>{dot(W.R.x, a), dot(W.R.y, a), dot(W.R.z, a)}; };
    const Vec<Block> off = goal.p - W.p;
    Block reach = root(dot(off, off)), shifted = CORRECTION_ROUNDING * (2.0 * apart.length[0] + root(dot(goal.p, goal.p)));
    for (int j = 0; j < 6; ++j) reach += apart.length[j + 1] * chord[j];
    for (int j = 0; j < 6; ++j) {
        shifted += (apart.shift[j + 1] + apart.turn[j + 1] * (apart.length[j + 1] + 2.0 * reach)) * chord[j];
    }
    Boxes next;
    family.include(family.arm, {each(goal.R, through), I.p + through(off)}, INFLATED * turned, INFLATED * shifted, first, next);
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
}

PART void certify_boxes(const IdealFrames& ideal, const Loop& loop, const Boxes& boxes, int first, Known& known,
                        double (&radii)[8]) {
    constexpr unsigned all = (1u << BLOCK) - 1;
    const Middle box = middle_of(boxes, ideal, first);
    const unsigned open = known.open >> first & all & bits(box.width <= Block(WIDEST_BOX));
    if (!open) return;
    // The other lanes repeat a box, so that they cost nothing more.
    const int one = __builtin_ctz(open);
    Block q[6], width = box.width;
    for (int j = 0; j < 6; ++j) q[j] = box.q[j];
    for (int l = 0; l < BLOCK; ++l) {
        if (open >> l & 1) continue;
        width.set(l, box.width[one]);
        for (int j = 0; j < 6; ++j) q[j].set(l, box.q[j][one]);
    }
    Turn<Block> turn[6];
    Orthogonal<Block> factors;
    LoopAt<Block> at;
    Block moved[6];
    for (Block& each : moved) each = 0.0;
    const auto step = [&] {
        const Six<Block> x = newton_step(factors, at.error);
        for (int j = 0; j < 6; ++j) q[j] = wrap(q[j] + x[j]), moved[j] = moved[j] + x[j];
    };
    for (int k = 0; k < STEPS; ++k) {
        turns_of(q, turn);
        at = loop_at(loop, turn);
        make_orthogonal(at.twist, factors);
        step();
    }
    Block far = 0.0;
    for (int j = 0; j < 6; ++j) far = max(far, abs(moved[j]));
    const Block radius = INFLATED * (width + far);
    turns_of(q, turn);
    at = loop_at(loop, turn);
    const Certificate root = certify(loop, at, factors, growth_of(q), radius);
    step();
    turns_of(q, turn);
    const auto converged = largest(loop_at(loop, turn).error) <= Block(CONVERGED);
    const unsigned found = open & bits(root.holds & (root.outer >= radius) & converged);
    known.found |= found << first, known.open &= ~(found << first);
    for (int l = 0; l < BLOCK; ++l) {
        if (!(found >> l & 1)) continue;
        radii[first + l] = radius[l];
        for (int j = 0; j < 6; ++j) known.angle[j][first + l] = q[j][l] + ideal.offset[j];
    }
}

Known certify_all(const Written<6>& written, const BothArms& both, const IdealFrames& ideal, const Goal<double>& goal,
                  const Seen<double>& seen, const Inclusion& family) {
    const Goal<Block> target = spread<Block>({seen.R, seen.p});
    const Displacement& apart = ideal.displacement;
    const double far = ideal.size + sqrt(dot(seen.p, seen.p));
    const Loop loop = loop_of(written, goal);
    Boxes boxes;
    Known known;
    double radii[8];
    for (int pass = 1; pass <= PASSES && known.open; ++pass) {
        for (int first = 0; first < 8; first += BLOCK) {
            if (!(known.open >> first & ((1u << BLOCK) - 1))) continue;
            if (pass == 1) {
                family.include(family.arm, {target.R, target.p}, apart.turn[0] + TARGET_ROUNDING,
                               apart.shift[0] + TARGET_ROUNDING * far, first, boxes);
                known.open &= ~boxes.empty;
            } else {
                narrow(both, apart, target, family, first, boxes, known.open);
            }
            certify_boxes(ideal, loop, boxes, first, known, radii);
        }
    }
    // Two boxes may lead to one root, which is the only one within either's radius.
    for (int b = 1; b < 8; ++b) {
        for (int a = 0; a < b && known.found >> b & 1; ++a) {
            double apart = 0.0;
            for (int j = 0; j < 6; ++j) apart = max(apart, abs(wrap(wrap(known.angle[j][a] - known.angle[j][b]))));
            if (known.found >> a & 1 && apart <= max(radii[a], radii[b])) known.found &= ~(1u << b);
        }
    }
    return known;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
