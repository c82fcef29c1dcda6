// The ideal arm's branches as starts of Newton's method on the arm as written; see imperfect.hpp.
#pragma once

#include "families/blocks.hpp"
#include "families/imperfect/imperfect_arm.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The eight branches of one pose: joint angles as (cos, sin), offsets included.
struct Answers {
    double c[6][8], s[6][8];
};
// What is known of the eight branches, a bit each.
struct Known {
    unsigned open = 255;   // not proven to be empty, and without a certified solution
    unsigned found = 0;    // has its own solution: certified by its box, or found by Newton's method nearby
    unsigned reached = 0;  // led to a vector that keeps the pose to the tolerance
    double angle[6][8];    // of the solutions, offsets included
};
// An ideal arm's closed form for a block of branches from `first` on.
struct IdealAnswer {
    const void* arm;
    void (*answer)(const void* arm, const Seen<Block>& seen, int first, Answers& to);
};

// Newton's method from all open branches.
Known follow_branches(const BothArms& arm, const Seen<double>& seen, const IdealAnswer& family, Known known);

}  // namespace urdf_ik::URDF_IK_LEVEL
