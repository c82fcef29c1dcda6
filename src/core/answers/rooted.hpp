// Interval inclusion through a closed form with a quartic: the discs of its roots are the first arcs of the boxes.
#pragma once

#include "answers/inclusion.hpp"
#include "arithmetic/quartic.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Whether a family's branches hang on the roots of a quartic. Bit root_bit of a branch's number tells root 0 from root 1, and 2
// from 3; the next higher one of the two bits that tell roots tells these pairs.
template <class Family> constexpr bool has_quartic() {
    return requires { &Family::quartic; } && !branches_have_signs<Family>();
}
template <class Family> STEP int root_of_branch(int b) { return Family::root_bit == 2 ? b >> 1 : (b >> 2) << 1 | (b & 1); }

// The status of one pose of an exact arm whose solutions are in the columns. A root that is not proven to be alone is a margin of
// either sign, that of the branches with the other root of its pair: roots are paired so that two that meet are one pair.
template <class Family>
PART Status status_by_roots(const typename Family::Arm& arm, const Goal<double>& goal, const Seen<double>& seen,
                            const Quartic& roots, const Columns<6>& columns) {
    using Number = Ball<Block>;
    if (!roots.whole) return keep_curve(arm.written, goal, columns) ? Status::continuum : Status::incomplete;
    const unsigned open = ~roots.alone & ((1u << roots.count) - 1);
    // The second root of a pair and the first one of the next, the last one's next being the first.
    const int shift = open == 6u || open == 9u;
    const Goal<Block> target = spread<Block>({seen.R, seen.p});
    const Slack off = slack_of(arm.ideal, seen);
    Boxes boxes;
    unsigned none = 0, either = 0;
    for (int first = 0; first < 8; first += BLOCK) {
        Turn<Number> root = {};
        const auto& of = arm.ideal.signs;
        const auto signs = [&](int k) { return Number(load<Block>(of[k] + first)); };
        for (int l = 0; l < BLOCK; ++l) {
            const int i = (root_of_branch<Family>(first + l) + shift) % 4;
            if (i >= roots.count) none |= 1u << (first + l);
            if (open >> i & 1) either |= 1u << (first + l);
            root.c.mid.set(l, roots.root[i].c), root.s.mid.set(l, roots.root[i].s);
            root.c.rad.set(l, roots.radius[i]), root.s.rad.set(l, roots.radius[i]);
        }
        const Seen<Number> all = within({target.R, target.p}, off.turn, off.shift);
        box(Family::template branch<Number>(arm, all, {signs(0), signs(1), signs(2), root}), first, boxes);
    }
    constexpr int pair = Family::root_bit == 2 ? 1 : 2;
    boxes.empty |= none, boxes.open[pair] |= either;
    for (int i = 0; i < roots.count; ++i) {
        for (int b = 0; b < 8 && roots.radius[i] < 0.5 * NEARER_THAN_ROUNDING; ++b) {
            if ((root_of_branch<Family>(b) + shift) % 4 == i) boxes.tiny[pair] |= either & 1u << b;
        }
    }
    // Each sure box holds one solution.
    if (!(boxes.free | open) && !(~boxes.sure() & ~boxes.empty & 255u) &&
        columns.count() == __builtin_popcount(~boxes.empty & 255u)) {
        return Status::complete;
    }
    // Wide discs leave joints free that the pose does not.
    const bool wide = boxes.free & either & ~boxes.empty;
    const Status status = wide ? Status::incomplete : decided(arm.ideal, boxes, filled_by(arm.ideal, boxes, columns));
    return status == Status::incomplete && keep_curve(arm.written, goal, columns) ? Status::continuum : status;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
