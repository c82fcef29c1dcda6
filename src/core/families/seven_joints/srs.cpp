// S-R-S arms, compiled once for every instruction set.
#include "families/seven_joints/srs_near.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

namespace {

// All branches of a block of targets, those past their ends included.
struct EveryBranch {
    Block q[8][7];
    unsigned unproven = 0;
    STEP void set(int b, const Block (&angles)[7], const MaskOf<Block>&, const MaskOf<Block>&) {
        for (int j = 0; j < 7; ++j) q[b][j] = angles[j];
    }
};

// See Batch::beyond. columns: the number of columns per pose, at least eight.
PART void branches_beyond_ends(const SrsArm& arm, const Batch& batch, int columns) {
    for (long start = 0; start < batch.m; start += BLOCK) {
        const int many = batch.m - start < BLOCK ? int(batch.m - start) : BLOCK;
        double T[16 * BLOCK];
        Block t[16], value = arm.value;
        for (int i = 0; i < BLOCK; ++i) {
            const long from = start + (i < many ? i : many - 1);
            __builtin_memcpy(T + 16 * i, batch.T + 16 * from, 16 * sizeof(double));
            if (batch.values) value.set(i, batch.values[from]);
        }
        load_poses(T, t);
        EveryBranch all;
        Srs::fast(arm, to_frame_1(t, arm.ideal), value, all);
        for (int i = 0; i < many; ++i) {
            double* to = batch.q + 7 * columns * (start + i);
            for (int b = 0; b < columns; ++b) {
                for (int j = 0; j < 7; ++j) to[7 * b + j] = b < 8 ? all.q[b][j][i] : __builtin_nan("");
            }
        }
    }
}

template <class Family, SolveArm<SrsArm> solve> long solve_srs(const SrsArm& arm, const Batch& batch) {
    if (!batch.beyond) return solve(arm, batch);
    branches_beyond_ends(arm, batch, Family::branches);
    return -1;
}

// The swivel angle of a joint vector.
double swivel_of(const SrsArm& arm, const double (&q)[7]) {
    double wrapped[7];
    for (int j = 0; j < 7; ++j) wrapped[j] = principal_angle(q[j]);
    const Posture<7, double> at = place(arm.written, wrapped);
    const Line<double> line = line_to_wrist(to_frame_1(at.tip, arm.ideal).p);
    const Vec<double> axis = times(arm.ideal.base_rotation, at.joint[3].R.z);
    return atan2(dot(line.across, axis), dot(line.normal, axis));
}

}  // namespace

extern const SrsSolvers srs_solvers = {solve_srs<Srs, solve_closed_form<Srs>>, solve_srs<SrsNear, solve_singly<SrsNear>>,
                                       swivel_of};

}  // namespace urdf_ik::URDF_IK_LEVEL
