// An arm near a family.
#pragma once

#include "families/closed_forms/parallel_shoulder_arm.hpp"
#include "families/closed_forms/spherical_middle_arm.hpp"
#include "families/closed_forms/spherical_wrist_arm.hpp"
#include "families/closed_forms/three_parallel_arm.hpp"
#include "families/general/elimination_arm.hpp"

namespace urdf_ik {

// A joint of the ideal arm counts as nearly free if its lever arm is below this multiple of the imperfection: on the arm as written
// its few values may then be anywhere on the circle.
inline constexpr double ALMOST_FREE = 5.0;

// The arm as written and the ideal one, from frame 1 to the point that is solved for. Both take the ideal arm's angles: joint
// values plus offsets.
struct BothArms {
    Written<6> written, ideal;
    int boxes;  // most boxes that are looked at to prove a pose; they decide the cost, and how often it stays open
};

template <class FamilyArm> struct ImperfectArm {
    FamilyArm family;  // the ideal arm
    // The same with a coarser tolerance: a joint counts as free if its lever arm is below ALMOST_FREE times the imperfection.
    FamilyArm loose;
    Written<6> written;
    EliminationArm elimination;
    BothArms both;
};

struct ImperfectSolvers {
    SolveArm<ImperfectArm<SphericalWristArm>> spherical_wrist[4];  // by Shoulder
    SolveArm<ImperfectArm<ThreeParallelArm>> three_parallel[2];  // by Hand
};
struct ImperfectSolversToo {
    SolveArm<ImperfectArm<ParallelShoulderArm>> parallel_shoulder[5];  // by LastAxes
    SolveArm<ImperfectArm<SphericalMiddleArm>> spherical_middle[3];  // by LastPair
};

}  // namespace urdf_ik
