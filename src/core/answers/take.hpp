// What becomes of a candidate of an arm whose closed form has no margins of its own to go by: it is polished, verified and
// kept if it is new, and near a fold of the Jacobian another solution is looked for beside it.
#pragma once

#include "answers/answer.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Where a candidate comes from: a closed form, one in which a joint was all but free (or of an arm that the form fits nearly),
// a search.
enum class Origin { computed, doubtful, searched };

// No candidate of a closed form comes to be a solution from this error [rad, share of size].
inline constexpr double HOPELESS = 0.05;
// Starts beside a solution near a fold: so many on each side along the direction that the Jacobian all but loses, from 0.1 rad
// (or share of the size), each a tenth of the one before.
inline constexpr int STARTS_BESIDE = 8;
// Two solutions beside a fold are two as long as their singular values are above this share of a singular one's; on a
// continuum they vanish.
inline constexpr double APART = 0.1;

// A solution beside q, if there is one. What is singular again belongs to the same double root, or to the same continuum.
template <class Model>
PART void take_beside(const Model& arm, const Goal<double>& goal, const double (&q)[Model::joints],
                      const Weakest<Model::joints>& weak, const Columns<Model::joints>& columns) {
    double away = 0.1;
    for (int k = 0; k < 2 * STARTS_BESIDE; ++k) {
        double start[Model::joints];
        for (int j = 0; j < Model::joints; ++j) start[j] = advanced(arm, j, q[j], (k % 2 ? away : -away) * weak.direction[j]);
        if (k % 2) away *= 0.1;
        if (polish_one<true>(arm, goal, start, {20, FINISHED, LONG_PATIENCE}).error > CONVERGED) continue;
        if (!is_new(arm, goal, columns, start)) continue;
        if (weakest_at(arm, goal, start).value > APART * arm.tolerances.singular) keep(columns, 0, start, 0);
    }
}

// Keep the candidate q if it is verified to `enough` and new; q is replaced. What was searched for is dropped where the arm is
// singular and a singular solution is known already: it belongs to the same continuum. Returns the smallest singular value
// there, at least whether it is below NEAR_FOLD, and infinity where q is no solution.
template <class Model>
PART double take(const Model& arm, const Goal<double>& goal, double (&q)[Model::joints], Origin origin, double enough,
                 const Columns<Model::joints>& columns) {
    constexpr int N = Model::joints;
    const bool computed = origin == Origin::computed;
    if (computed && !(error_at<N, double>(arm, goal, q).size <= HOPELESS)) return __builtin_inf();
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
            if (columns.flags[b] & OTHER) return weak.value;
        }
    }
    if (!is_new(arm, goal, columns, q)) return weak.value;
    keep(columns, 0, q, singular ? OTHER : 0);
    if (weak.value <= NEAR_FOLD) take_beside(arm, goal, q, weak, columns);
    return weak.value;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
