// Decides which branches of an arm near a family are solutions of the arm as written; see imperfect.hpp.
#pragma once

#include "answers/blocks.hpp"
#include "families/imperfect/imperfect_arm.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The eight branches of one pose, each solved for its own corrected target: joint angles as (cos, sin), offsets included, and the
// margins of shoulder, elbow and wrist.
struct Answers {
    double c[6][8], s[6][8], margin[3][8], arms[8];
};
// The result, one bit per branch: not decided yet, and decided to be a solution.
struct Known {
    unsigned open = 255, found = 0;
    double least_arm = 1.0;  // squared, of all branches [share of size^2]
    double angle[6][8];      // of the solutions, offsets included
};
// An ideal arm's closed form for a block of branches from `first` on.
struct IdealAnswer {
    const void* arm;
    void (*answer)(const void* arm, const Seen<Block>& seen, int first, Answers& to);
};

// known: which branches are open.
Known decide_all(const BothArms& arm, const Seen<double>& seen, const IdealAnswer& family, Known known);

}  // namespace urdf_ik::URDF_IK_LEVEL
