// What the solver of an arm near a family knows of it.
#pragma once

#include "families/closed_forms/parallel_shoulder_arm.hpp"
#include "families/closed_forms/spherical_middle_arm.hpp"
#include "families/closed_forms/spherical_wrist_arm.hpp"
#include "families/closed_forms/three_parallel_arm.hpp"
#include "families/general/elimination_arm.hpp"

namespace urdf_ik {

// Up to this multiple of its imperfection an arm that turns freely on the ideal arm does so almost: on the arm as written its few
// true values lie anywhere on the circle.
inline constexpr double ALMOST_FREE = 5.0;

// From frame 1 to the point that is solved for: the arm as written, and the ideal one, both by the ideal arm's angles, joint values
// and offsets together.
struct BothArms {
    Written<6> written, ideal;
    double drift;  // how fast the motion between the two tips changes with the joints, at most [rad, share of size; a rad]
};

template <class FamilyArm> struct ImperfectArm {
    FamilyArm family;  // the ideal arm
    // The same, which counts a joint as free where its squared arm is below ALMOST_FREE times the imperfection, squared.
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
