// An arm near a family.
#pragma once

#include "families/closed_forms/parallel_shoulder_arm.hpp"
#include "families/closed_forms/spherical_middle_arm.hpp"
#include "families/closed_forms/spherical_wrist_arm.hpp"
#include "families/closed_forms/three_parallel_arm.hpp"
#include "families/general/elimination_arm.hpp"

namespace urdf_ik {

// The arm as written and the ideal one, from frame 1 to the point that is solved for. Both take the ideal arm's angles: joint
// values plus offsets.
struct BothArms {
    Written<6> written, ideal;
};

template <class FamilyArm> struct ImperfectArm {
    FamilyArm family;  // the ideal arm
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
