// Proves the branches of an arm that is very near to a family; see imperfect.hpp.
#pragma once

#include "answers/inclusion.hpp"
#include "families/imperfect/decide.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// An ideal arm's closed form on balls: include() of answers/inclusion.hpp.
struct Inclusion {
    const void* arm;
    void (*include)(const void* arm, const Seen<Block>& target, const Block& turn, const Block& shift, int first, Boxes& to);
};

// Each real solution lies in one of eight boxes, which hold the solutions of a branch for every displacement between the ideal arm
// and the arm as written; each later pass takes only the displacements of the joint vectors in the box. A box is decided where it
// is empty, or where Newton's method from its centre leads to a certified root that is the only one in a ball that holds the box.
// If no branch is open, the branches that are found lead to all solutions, each once. goal: for the arm as written; seen: the same
// in frame 1.
Known certify_all(const Written<6>& written, const BothArms& both, const IdealFrames& ideal, const Goal<double>& goal,
                  const Seen<double>& seen, const Inclusion& family);

}  // namespace urdf_ik::URDF_IK_LEVEL
