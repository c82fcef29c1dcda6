// The solvers compiled for one instruction set: pointers to the functions of each unit.
#pragma once

#include "chain_arm.hpp"
#include "families/closed_forms/parallel_shoulder_arm.hpp"
#include "families/closed_forms/reversed.hpp"
#include "families/closed_forms/spherical_middle_arm.hpp"
#include "families/closed_forms/spherical_wrist_arm.hpp"
#include "families/closed_forms/three_parallel_arm.hpp"
#include "families/few_joints/few_joints_arm.hpp"
#include "families/general/elimination_arm.hpp"
#include "families/mimics/coupled_arm.hpp"
#include "families/seven_joints/one_given_arm.hpp"
#include "families/seven_joints/srs_arm.hpp"
#include "motion/path_graph.hpp"
#include "motion/self_motion/curve_arm.hpp"
#include "motion/tracker_arm.hpp"

namespace urdf_ik {

struct LevelTable {
    const char* name;
    const CoupledSolvers* coupled;
    const OneGivenSolvers* one_given;
    const ChainFunctions* chain;
    const InverseFunctions* inverse;
    const GraphFunctions* graph;
    const TrackerFunctions* tracker;
    const SelfMotionFunctions* self_motion;
    const ParallelShoulderSolvers* parallel_shoulder;
    const FewJointsSolvers* few_joints;
    const ReversedSteps* reversed;
    const SphericalMiddleSolvers* spherical_middle;
    const SphericalWristSolvers* spherical_wrist;
    const SrsSolvers* srs;
    const ThreeParallelSolvers* three_parallel;
    const EliminationSolvers* elimination;
};

}  // namespace urdf_ik
