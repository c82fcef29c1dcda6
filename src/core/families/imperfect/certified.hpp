// Proves the branches of an arm that is very near to a family; see imperfect.hpp.
#pragma once

#include "certify/single.hpp"
#include "families/imperfect/starts.hpp"
#include "families/inclusion.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// An ideal arm's closed form on balls: include() of families/inclusion.hpp.
struct Inclusion {
    const void* arm;
    void (*include)(const void* arm, const Seen<Block>& target, const Block& turn, const Block& shift, int first, Boxes& to);
};

// Half the width [rad] of the widest box from which a root can be shown to be alone: the norm of each joint's twist is at least
// sqrt(2), and S r in certify/single.hpp at most LARGEST_BALL.
inline constexpr double WIDEST_BOX = LARGEST_BALL / (6.0 * 1.414);

// Each real solution lies in one of eight boxes, which hold the solutions of a branch for every displacement between the ideal arm
// and the arm as written; each later pass takes only the displacements of the joint vectors in the box. A box is decided where it
// is empty, or where Newton's method from its centre leads to a certified root that is the only one in a ball that holds the box.
// goal: for the arm as written; seen: the same in frame 1. known: the branches that are open, and those that led to a root of
// their own.
void certify_all(const Written<6>& written, const BothArms& both, const IdealFrames& ideal, const Goal<double>& goal,
                 const Seen<double>& seen, const Inclusion& family, Known& known);

}  // namespace urdf_ik::URDF_IK_LEVEL
