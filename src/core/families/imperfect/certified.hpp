// Proves the branches of an arm that is very near to a family; see imperfect.hpp.
#pragma once

#include "answers/inclusion.hpp"
#include "certificate/single.hpp"
#include "families/imperfect/starts.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Targets of the ideal arm for the joint vectors middle + along t, |t| <= 1, in a block of boxes: within `turn` and `shift` of
// middle + moving t.
struct Targets {
    Seen<Block> middle, moving;
    Block turn, shift;
};
// An ideal arm's closed form on balls: include() of answers/inclusion.hpp.
struct Inclusion {
    const void* arm;
    void (*include)(const void* arm, const Seen<Block>& target, const Block& turn, const Block& shift, int first, Boxes& to);
    void (*within)(const void* arm, const Targets& targets, const Signs<Block>& signs, const Arcs<Block>& known, BoxBlock& to);
    // The joints that others follow from, in the order of the steps: a box is halved along the first one that is wide. It decides
    // the cost only.
    int leading[3];
};

// The targets of the ideal arm for the joint vectors within `rest` of turn + along t. chord: of half of the whole arcs; a whole
// circle has a chord of 2.
Targets targets_of(const BothArms& arm, const Displacement& apart, const Goal<Block>& goal, const Turn<Block> (&turn)[6],
                   const Block (&chord)[6], const Block (&along)[6], const Block (&rest)[6]);

// Half the width [rad] of the widest box from which a root can be shown to be alone: the norm of each joint's twist is at least
// sqrt(2), and S r in certificate/single.hpp at most LARGEST_BALL.
inline constexpr double WIDEST_BOX = LARGEST_BALL / (6.0 * 1.414);
// A certified root from the middle of each box, for a block of boxes.
struct Rooted {
    Block q[6], radius;  // joint values; there is no other root within radius, which holds the box
    unsigned found;
};
// q, half: middle and half the width of each box; only lanes in `wanted` are computed.
Rooted root_of(const Loop& loop, const Block (&q)[6], const Block& half, unsigned wanted);

// Certified roots, joint values of the arm as written, each with the branch of the box that led there. There is no other root
// within its radius. singular: roots that stand as one, or one whose Jacobian nearly loses a rank. stands: it stands for others.
struct Certified {
    static constexpr int most = 16;
    struct Root {
        double q[6], radius;
        int branch;
        bool singular, stands = false;
    } root[most];
    int many = 0;
    Status status = Status::incomplete;  // complete or clustered: the roots are all

    // Adds a root unless it lies within the radius of a known one, or the other way round: then they are the same.
    bool add(const double (&q)[6], double radius, int branch, bool singular);
};

// Each real solution lies in one of eight boxes, which hold the solutions of a branch for every displacement between the ideal arm
// and the arm as written; each later pass takes only the displacements of the joint vectors in the box. A box is decided where it
// is empty, or where Newton's method from its centre leads to a certified root that is the only one in a ball that holds the box.
// What stays open is divided (divided.hpp) if `divides`. goal: for the arm as written; seen: the same in frame 1. known: the
// branches that are open, and those that led to a root of their own.
Certified certify_all(const Written<6>& written, const BothArms& both, const IdealFrames& ideal, const Goal<double>& goal,
                      const Seen<double>& seen, const Inclusion& family, bool divides, Known& known);

}  // namespace urdf_ik::URDF_IK_LEVEL
