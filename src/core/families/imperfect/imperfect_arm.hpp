// An arm near a family.
#pragma once

#include "families/general/elimination_arm.hpp"

namespace urdf_ik {

// The arm as written and the ideal one, from frame 1 to the point that is solved for. Both take the ideal arm's angles: joint
// values plus offsets.
struct BothArms {
    Written<6> written, ideal;
};

template <class FamilyArm> struct ImperfectArm {
    FamilyArm family;  // the ideal arm's closed form; its `written` is the arm as written, for polishing
    Written<6> written;
    EliminationArm elimination;
    BothArms both;  // the same two arms from frame 1 on, without their ends
};

// A family's solvers by its kinds: of exact arms, and of arms near them.
template <class Arm, int kinds> struct FamilySolvers {
    SolveArm<Arm> solve[kinds];
    SolveArm<ImperfectArm<Arm>> near[kinds];
};

}  // namespace urdf_ik
