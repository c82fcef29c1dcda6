// Arms of six joints that are singular everywhere: a pose that they reach has a continuum of solutions, which is sampled.
//
// Newton's method runs from starts all over the joint space. Its steps are least-squares steps, so it ends on the
// continuum near its start, and the samples are spread as the starts are. Seven joints with a middle one held are
// solved alike: the arm of the six others depends on the held value, so nothing can be prepared for it.
#pragma once

#include "families/blocks.hpp"
#include "families/few_joints/few_joints_arm.hpp"
#include "referee/on_curve.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Samples of a continuum are at least this far apart in some joint [rad, share of size].
inline constexpr double SPREAD = 0.3;
// Largest number of starts. A pose with solutions is finished after ENOUGH_STARTS starts without a new one if they are
// samples of a continuum. Isolated solutions need ENOUGH_BESIDE_SINGLE, since others may be hard to find beside them.
inline constexpr int MOST_STARTS = 512, ENOUGH_STARTS = 64, ENOUGH_BESIDE_SINGLE = 192;
// Where several continua meet, each step gains little. If no start led to a solution, the best starts with an error
// below WITHIN_REACH get SLOW_ROUNDS rounds.
inline constexpr double WITHIN_REACH = 1e-5;
inline constexpr int SLOW_ROUNDS = 2000;

struct Sampled {
    using Arm = SampledArm;
    static constexpr int branches = 16;

    static STEP bool is_apart(const Written<6>& arm, const Columns<6>& columns, const double (&q)[6]) {
        for (int b = 0; b < columns.many; ++b) {
            if (columns.valid(b) && distance(arm, q, columns.row(b)) < SPREAD) return false;
        }
        return true;
    }

    // Keep the solution q if it is isolated and new, or a sample of a continuum far enough from the others. Returns whether it was
    // kept.
    static PART bool keep_sample(const Written<6>& arm, const Goal<double>& goal, const double (&q)[6], const Columns<6>& columns) {
        const int marks = singular_marks(arm, goal, q, OTHER);
        if (columns.count() == columns.many || !(marks ? is_apart(arm, columns, q) : is_new(arm, goal, columns, q))) return false;
        keep(columns, 0, q, marks);
        return true;
    }

    static PART void search(const Written<6>& arm, const Goal<double>& goal, const Reference<6>& reference,
                            const Columns<6>& columns) {
        const Goal<Block> goals = spread<Block>(goal);
        Scatter scatter = Scatter::number(0);
        double nearest[BLOCK][6], least[BLOCK];
        for (double& each : least) each = WITHIN_REACH;
        int enough = ENOUGH_STARTS;
        for (int k = 0, since = 0; k < MOST_STARTS && since < enough && columns.count() < columns.many; k += BLOCK) {
            Block start[6];
            scatter_over(arm, scatter, start);
            for (int j = 0; j < 6 && !k; ++j) start[j].set(0, reference.q[j]);
            const Block error = polish_block<true>(arm, goals, start, {60, FINISHED, PATIENCE}).error;
            since += columns.count() ? BLOCK : 0;
            for (int l = 0; l < BLOCK; ++l) {
                double q[6];
                for (int j = 0; j < 6; ++j) q[j] = start[j][l];
                if (error[l] <= CONVERGED) {
                    if (!keep_sample(arm, goal, q, columns)) continue;
                    since = 0;
                } else if (error[l] < least[l]) {
                    least[l] = error[l];
                    for (int j = 0; j < 6; ++j) nearest[l][j] = q[j];
                }
            }
            for (int b = 0; b < columns.many; ++b) {
                if (columns.flags[b] == VALID) enough = ENOUGH_BESIDE_SINGLE;
            }
        }
        for (int l = 0; l < BLOCK && !columns.count(); ++l) {
            if (least[l] < WITHIN_REACH &&
                polish_one<true>(arm, goal, nearest[l], {SLOW_ROUNDS, CONVERGED, SLOW_ROUNDS}).error <= arm.tolerances.reach)
                keep_sample(arm, goal, nearest[l], columns);
        }
        sort(columns);
        // A search cannot prove that its result is complete.
        set_status(columns.flags[0], any_is_on_curve(arm, goal, columns) ? Status::continuum : Status::incomplete);
    }

    static PART void solve(const Arm& arm, const Goal<double>& goal, const Reference<6>& reference, const Columns<6>& columns) {
        search(arm.written, goal, reference, columns);
    }
};

// The motion `first`, then that of the joint at its value, then `next`.
STEP Motion joined(const Motion& first, bool slides, double value, const Motion& next) {
    return motion_of(beyond(moved(constant_frame<double>(first), slides, value), next));
}

struct SampledHeld {
    using Arm = SampledHeldArm;
    static constexpr int branches = Sampled::branches;
    static constexpr bool redundant = true;

    static PART void solve(const Arm& arm, const Goal<double>& goal, double value, const Reference<7>& reference,
                           const Columns<7>& columns) {
        const int held = arm.held;
        const double at = principal_value(value, !arm.written.slides[held]);
        Written<6> others = {};
        others.size = arm.written.size, others.tolerances = arm.written.tolerances;
        Reference<6> near = reference_of<6>(nullptr);
        near.given = reference.given;
        for (int j = 0; j < 6; ++j) {
            others.slides[j] = arm.written.slides[j + (j >= held)], near.q[j] = reference.q[j + (j >= held)];
        }
        for (int j = 0; j < 7; ++j) {
            others.step[j] = j == held ? joined(arm.written.step[j], arm.written.slides[j], at, arm.written.step[j + 1])
                                       : arm.written.step[j + (j > held)];
        }
        double room[6 * branches];
        const Columns<6> found = {room, columns.flags, columns.many};
        found.clear();
        Sampled::search(others, goal, near, found);
        for (int b = 0; b < columns.many; ++b) {
            double* row = columns.row(b);
            for (int j = 0; j < 7; ++j)
                row[j] = j == held ? (found.valid(b) ? at : __builtin_nan("")) : found.row(b)[j - (j > held)];
        }
    }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
