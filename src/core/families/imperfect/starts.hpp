// The ideal arm's branches as starts of Newton's method on the arm as written; see imperfect.hpp.
#pragma once

#include "answers/blocks.hpp"
#include "families/imperfect/imperfect_arm.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The eight branches of one pose: joint angles as (cos, sin), offsets included.
struct Answers {
    double c[6][8], s[6][8];
};
// The result, one bit per branch: neither empty nor found; its own solution found; Newton's method led from it to a solution.
struct Known {
    unsigned open = 255, found = 0, reached = 0;
    double angle[6][8];  // of the solutions, offsets included
};
// An ideal arm's closed form for a block of branches from `first` on.
struct IdealAnswer {
    const void* arm;
    void (*answer)(const void* arm, const Seen<Block>& seen, int first, Answers& to);
};

// Newton's method from all open branches.
Known follow_branches(const BothArms& arm, const Seen<double>& seen, const IdealAnswer& family, Known known);

}  // namespace urdf_ik::URDF_IK_LEVEL
