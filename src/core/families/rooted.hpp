// Interval inclusion through a closed form with a quartic: the discs of its roots are the first arcs of the boxes.
#pragma once

#include "families/inclusion.hpp"
#include "referee/referee.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The boxes of one pose of an exact arm. A root that is not proven to be alone is a margin of either sign, that of the branches
// with the other root of its pair: roots are paired so that two that meet are one pair. So where the second root of a pair meets
// the first one of the next, each branch takes the next root, the last one's next being the first.
template <class Family>
PART Boxes boxes_by_roots(const typename Family::Arm& arm, const Seen<double>& seen, const Quartic& roots) {
    using Number = Ball<Block>;
    constexpr int pair = Family::root_bit == 2 ? 1 : 2;
    const Goal<Block> target = spread<Block>(seen);
    const Slack off = slack_of(arm.ideal, seen);
    const Seen<Number> all = within(target, off.turn, off.shift);
    const unsigned open = ~roots.alone & ((1u << roots.count) - 1);
    const bool shifted = open == 6u || open == 9u;
    Boxes boxes;
    for (int first = 0; first < 8; first += BLOCK) {
        Turn<Number> root = {};
        const auto signs = [&](int k) { return Number(load<Block>(arm.ideal.signs[k] + first)); };
        for (int l = 0; l < BLOCK; ++l) {
            const int i = (root_of_branch<Family>(first + l) + shifted) % 4;
            const unsigned bit = 1u << (first + l);
            const bool either = open >> i & 1u;
            boxes.empty |= i >= roots.count ? bit : 0, boxes.open[pair] |= either ? bit : 0;
            boxes.tiny[pair] |= either && roots.radius[i] < 0.5 * NEARER_THAN_ROUNDING ? bit : 0;
            root.c.mid.set(l, roots.root[i].c), root.s.mid.set(l, roots.root[i].s);
            root.c.rad.set(l, roots.radius[i]), root.s.rad.set(l, roots.radius[i]);
        }
        const auto at = Family::template branch<Number>(arm, all, {signs(0), signs(1), signs(2), root});
        box({at.shoulder, at.elbow, at.wrist}, at.turn, first, boxes);
    }
    return boxes;
}

// All solutions of one pose of an exact arm whose closed form has a quartic, and its status. Its rotation is a rotation.
template <class Family>
PART Status solve_by_roots(const typename Family::Arm& arm, const Goal<double>& goal, const Reference<6>& reference,
                           const Columns<6>& columns) {
    const Seen<double> seen = to_frame_1(goal, arm.ideal);
    const Quartic roots = Family::quartic(arm, seen);
    Status status = Status::incomplete;
    if (!roots.whole) {
        propose<Family>(arm, goal, seen, roots, reference, both_roots, 255u, columns);
    } else {
        const Boxes boxes = boxes_by_roots<Family>(arm, seen, roots);
        status = fill<Family>(arm, goal, seen, roots, reference, boxes, 255u, columns);
        // Wide discs leave joints free that the pose does not.
        if (boxes.free & boxes.open[Family::root_bit == 2 ? 1 : 2] & ~boxes.empty) status = Status::incomplete;
    }
    if (status == Status::incomplete && any_is_on_curve(arm.written, goal, columns)) return Status::continuum;
    return status == Status::incomplete ? refer(arm.written, goal, columns) : status;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
