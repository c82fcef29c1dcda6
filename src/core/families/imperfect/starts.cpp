// See starts.hpp. Compiled once for every instruction set.
#include "families/imperfect/starts.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Each start is within about the square of the imperfection of its branch's solution. A lane that gains nothing in two rounds leads
// nowhere.
inline constexpr Course FROM_BRANCHES = {6, CONVERGED, 2};

// I(q) W(q)^-1 goal.
PART Seen<Block> corrected(const BothArms& arm, const Goal<Block>& goal, const Turn<Block> (&turn)[6]) {
    Frame<Block> joint[6];
    const Frame<Block> W = joints_and_tip(arm.written, turn, joint), I = joints_and_tip(arm.ideal, turn, joint);
    const auto through = [&](const Vec<Block>& a) { return I.R * Vec<Block>{dot(W.R.x, a), dot(W.R.y, a), dot(W.R.z, a)}; };
    return {each(goal.R, through), I.p + through(goal.p - W.p)};
}

// Newton's method from one block of the open branches.
PART void follow(const BothArms& arm, const Goal<Block>& goal, const Answers& start, int first, Known& known) {
    const unsigned open = known.open >> first & ((1u << BLOCK) - 1);
    Block q[6], from[6], chosen, moved = 0.0;
    for (int j = 0; j < 6; ++j) q[j] = from[j] = atan2(load<Block>(start.s[j] + first), load<Block>(start.c[j] + first));
    for (int l = 0; l < BLOCK; ++l) chosen.set(l, open >> l & 1);
    const Polished<Block> end = polish_block<false>(arm.written, goal, q, FROM_BRANCHES, chosen > Block(0.5));
    for (int j = 0; j < 6; ++j) moved = max(moved, abs(wrap(q[j] - from[j])));
    const unsigned reached = open & bits(end.error <= Block(arm.written.tolerances.reach));
    const unsigned found = open & bits((end.error <= Block(CONVERGED)) & (moved <= 0.5 * end.least) &
                                       (end.least >= Block(arm.written.tolerances.singular)));
    known.reached |= reached << first, known.found |= found << first, known.open &= ~(found << first);
    for (int l = 0; l < BLOCK; ++l) {
        for (int j = 0; j < 6 && reached >> l & 1; ++j) known.angle[j][first + l] = q[j][l];
    }
}

Known follow_branches(const BothArms& arm, const Seen<double>& seen, const IdealAnswer& family, Known known) {
    const Goal<Block> target = spread<Block>(seen);
    for (int first = 0; first < 8; first += BLOCK) {
        if (!(known.open >> first & ((1u << BLOCK) - 1))) continue;
        Answers now;
        family.answer(family.arm, target, first, now);
        Turn<Block> turn[6];
        for (int j = 0; j < 6; ++j) turn[j] = {load<Block>(now.c[j] + first), load<Block>(now.s[j] + first)};
        family.answer(family.arm, corrected(arm, target, turn), first, now);
        follow(arm, target, now, first, known);
    }
    return known;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
