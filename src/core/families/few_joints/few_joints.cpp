// Arms with few joints and arms with slides, compiled once for every instruction set.
#include "families/few_joints/completed.hpp"
#include "families/few_joints/planar.hpp"
#include "families/few_joints/sampled.hpp"
#include "families/few_joints/slides.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

extern const FewJointsSolvers few_joints_solvers = {
    solve_singly<FewJoints<1, 1>>, solve_singly<FewJoints<2, 2>>, solve_singly<FewJoints<3, 4>>, solve_singly<FewJoints<3, 2>>,
    solve_singly<FewJoints<4, 4>>, solve_singly<FewJoints<5, 8>>, solve_closed_form<Planar<2>>,  solve_closed_form<PlanarPoints<2>>,
    solve_closed_form<Planar<3>>,  solve_closed_form<Planar<4>>,  solve_singly<Slides<2>>,       solve_singly<Slides<4>>,
    solve_singly<Slides<8>>,       solve_singly<Sampled>,         solve_singly<SampledHeld>,     keep_real,
};

}  // namespace urdf_ik::URDF_IK_LEVEL
