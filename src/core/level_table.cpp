// The table of one instruction set; see level_table.hpp.
#include "level_table.hpp"

#include "numbers/level.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

extern const CoupledSolvers coupled_solvers;
extern const OneGivenSolvers one_given_solvers;
extern const ChainFunctions chain_functions;
extern const InverseFunctions inverse_functions;
extern const GraphFunctions graph_functions;
extern const ParallelShoulderSolvers parallel_shoulder_solvers;
extern const EliminationSolvers elimination_solvers;
extern const FewJointsSolvers few_joints_solvers;
extern const ReversedSteps reversed_steps;
extern const SphericalMiddleSolvers spherical_middle_solvers;
extern const TrackerFunctions tracker_functions;
extern const SelfMotionFunctions self_motion_functions;
extern const SphericalWristSolvers spherical_wrist_solvers;
extern const SrsSolvers srs_solvers;
extern const ThreeParallelSolvers three_parallel_solvers;

extern const LevelTable table = {
    URDF_IK_TEXT(URDF_IK_LEVEL), &coupled_solvers,    &one_given_solvers,      &chain_functions,
    &inverse_functions,          &graph_functions,    &tracker_functions,      &self_motion_functions,
    &parallel_shoulder_solvers,  &few_joints_solvers, &reversed_steps,         &spherical_middle_solvers,
    &spherical_wrist_solvers,    &srs_solvers,        &three_parallel_solvers, &elimination_solvers,
};

}  // namespace urdf_ik::URDF_IK_LEVEL
