// Solutions of a completed arm (five joints and an added one) that are also solutions of the real arm.
#pragma once

#include "arm/target.hpp"
#include "families/few_joints/few_joints_arm.hpp"
#include "propose/candidates.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Verifies the solutions of the six joints on the real arm. At a singularity of the completed arm the added joint may
// move along a continuum that holds isolated solutions of the real arm. A search all over the joint space then finds them.
PART void keep_real(const CompletedArm& arm, const Batch& batch, const OfSix& six) {
    for (long i = 0; i < batch.m; ++i) {
        double proper[16];
        project_rotation(batch.T + 16 * i, proper);
        const Goal<double> goal = goal_of(proper);
        const Columns<5> columns = {batch.q + 5 * arm.columns * i, batch.flags + arm.columns * i, arm.columns};
        columns.clear();
        bool free = false;
        // On a continuum of the six a singular solution may be another member of the five's own.
        const Status of_six = status_of(six.flags[six.columns * i]);
        const Origin origin = of_six == Status::continuum ? Origin::searched : Origin::computed;
        for (int b = 0; b < six.columns; ++b) {
            const int flags = six.flags[six.columns * i + b];
            if (!(flags & VALID)) continue;
            free |= (flags & ~STATUS_BITS) != VALID;
            double q[5];
            for (int j = 0; j < 5; ++j) q[j] = six.q[6 * (six.columns * i + b) + arm.at + j];
            polish_and_keep(arm.written, goal, q, origin, arm.written.tolerances.reach, columns);
        }
        if (free && arm.written.task == Task::pose) search_all_over(arm.written, goal, Origin::searched, CONVERGED, columns);
        sort(columns);
        // On a continuum of the six, isolated solutions of the five may be missing: the net is a search.
        set_status(columns.flags[0], of_six == Status::continuum ? Status::incomplete : of_six);
    }
}

}  // namespace urdf_ik::URDF_IK_LEVEL
