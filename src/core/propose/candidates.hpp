// Candidates of arms whose closed form has no margins: each is polished, verified and kept if it is new. Near a fold a second
// solution is searched for beside it.
#pragma once

#include "propose/answer.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The origin of a candidate: a closed form; a closed form in which a joint was nearly free, or of an arm that only approximates
// this one; a search.
enum class Origin { computed, doubtful, searched };

// A closed form's candidate with a larger error than this leads to no solution [rad, share of size].
inline constexpr double HOPELESS = 0.05;
// Starts on each side of a solution near a fold, along the Jacobian's weakest direction: the first one 0.1 rad (or share of the
// size) away, each further one a tenth of the distance before.
inline constexpr int STARTS_BESIDE = 8;
// Starts all over the joint space.
inline constexpr int ALL_OVER = 160;

// Keep a second solution beside q, if there is one. A singular one may belong to the same continuum.
template <class Model>
PART void keep_beside(const Model& arm, const Goal<double>& goal, const double (&q)[Model::joints],
                      const Weakest<Model::joints>& weak, const Columns<Model::joints>& columns) {
    double away = 0.1;
    for (int k = 0; k < 2 * STARTS_BESIDE; ++k) {
        double start[Model::joints];
        for (int j = 0; j < Model::joints; ++j) start[j] = q[j];
        const double step = k % 2 ? away : -away;
        if (k % 2) away *= 0.1;
        if (move_along(arm, goal, {20, FINISHED, LONG_PATIENCE}, step, weak.direction, start) > CONVERGED) continue;
        if (!is_new(arm, goal, columns, start)) continue;
        const int marks = singular_marks(arm, goal, start, 0);
        if (!marks || !is_joined(arm, goal, start, q)) keep(columns, 0, start, marks);
    }
}

// Polish the candidate q, and keep it if its error is at most `enough` and it is new; q is replaced. A singular result of a search
// is dropped if it lies on one continuum with a known one. Returns the Jacobian's smallest
// singular value there (only a lower bound if that is above NEAR_FOLD), or infinity if q is not a solution.
template <class Model>
PART double polish_and_keep(const Model& arm, const Goal<double>& goal, double (&q)[Model::joints], Origin origin, double enough,
                            const Columns<Model::joints>& columns) {
    constexpr int N = Model::joints;
    const bool computed = origin == Origin::computed;
    if (computed && !(missed_by(arm, goal, q) <= HOPELESS)) return __builtin_inf();
    const Polished<double> found = polish_one<true>(arm, goal, q, {computed ? 15 : 30, FINISHED, LONG_PATIENCE});
    if (!(found.error <= enough)) return __builtin_inf();
    if (found.least > NEAR_FOLD) {
        if (is_new(arm, goal, columns, q)) keep(columns, 0, q, 0);
        return found.least;
    }
    const Weakest<N> weak = weakest_at(arm, goal, q);
    const bool singular = weak.value <= arm.tolerances.singular;
    if (origin == Origin::searched && singular) {
        for (int b = 0; b < columns.many; ++b) {
            if (columns.flags[b] & OTHER && is_joined(arm, goal, q, columns.row(b))) return weak.value;
        }
    }
    if (!is_new(arm, goal, columns, q)) return weak.value;
    keep(columns, 0, q, singular ? OTHER : 0);
    if (weak.value <= NEAR_FOLD) keep_beside(arm, goal, q, weak, columns);
    return weak.value;
}

// Keeps what Newton's method reaches from starts all over the joint space.
template <int N> PART void search_all_over(const Written<N>& arm, const Goal<double>& goal, Origin origin, double enough,
                                           const Columns<N>& columns) {
    Scatter scatter = Scatter::number(0);
    for (int from = 0; from < ALL_OVER; from += BLOCK) {
        Block start[N];
        scatter_over(arm, scatter, start);
        const Block error = polish_block<true>(arm, spread<Block>(goal), start, {30, FINISHED, PATIENCE}).error;
        for (int l = 0; l < BLOCK; ++l) {
            double q[N];
            for (int j = 0; j < N; ++j) q[j] = start[j][l];
            if (!(error[l] <= arm.tolerances.reach) || !is_new(arm, goal, columns, q)) continue;
            polish_and_keep(arm, goal, q, origin, enough, columns);
        }
    }
}

}  // namespace urdf_ik::URDF_IK_LEVEL
