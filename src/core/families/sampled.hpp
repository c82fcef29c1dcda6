// Arms of six joints that are singular everywhere: a pose that they reach leaves a continuum, of which samples are given.
//
// Newton's method runs from starts all over the joints. Its steps are of least squares, so it comes to rest on the continuum near
// where it began, and the samples are spread about as the starts are.
#pragma once

#include "../blocks.hpp"
#include "few_joints_arm.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Samples are at least this far apart in some joint [rad].
inline constexpr double SPREAD = 0.3;
// Starts at most, and after how many a pose that has samples is done.
inline constexpr int MOST_STARTS = 512, ENOUGH_STARTS = 64;

struct Sampled {
    using Arm = SampledArm;
    static constexpr int branches = 16;

    static STEP bool is_apart(const Columns<6>& columns, const double (&q)[6]) {
        for (int b = 0; b < columns.many; ++b) {
            double apart = 0.0;
            for (int j = 0; j < 6; ++j) apart = max(apart, abs(wrap(q[j] - columns.row(b)[j])));
            if (columns.valid(b) && apart < SPREAD) return false;
        }
        return true;
    }

    static PART void solve(const Arm& arm, const Goal<double>& goal, const Reference<6>& reference, const Columns<6>& columns) {
        const Goal<Block> goals = spread<Block>(goal);
        const Block zero = 0.0;
        Scatter scatter = Scatter::number(0);
        for (int k = 0; k < MOST_STARTS && columns.count() < columns.many; k += BLOCK) {
            if (k >= ENOUGH_STARTS && columns.count()) break;
            Block start[6];
            for (int l = 0; l < BLOCK; ++l) {
                for (int j = 0; j < 6; ++j) {
                    const double angle = PI * scatter.next();
                    start[j].set(l, k + l ? angle : reference.q[j]);
                }
            }
            const Block error =
                polish<true, Written<6>, Block>(arm.written, goals, start, {60, FINISHED, PATIENCE}, zero <= zero).error;
            for (int l = 0; l < BLOCK; ++l) {
                double q[6];
                for (int j = 0; j < 6; ++j) q[j] = start[j][l];
                if (error[l] <= CONVERGED && columns.count() < columns.many && is_apart(columns, q))
                    keep(columns, 0, q, singular_marks(arm.written, goal, q, OTHER));
            }
        }
        sort(columns);
        // Samples of what a search has found.
        columns.flags[0] |= UNCERTAIN;
    }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
