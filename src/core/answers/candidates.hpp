// Candidates of arms whose closed form has no margins: each is polished, verified and kept if it is new.
#pragma once

#include "answers/answer.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The origin of a candidate: a closed form; a closed form in which a joint was nearly free, or of an arm that only approximates
// this one; a search.
enum class Origin { computed, doubtful, searched };

// A closed form's candidate with a larger error than this leads to no solution [rad, share of size].
inline constexpr double HOPELESS = 0.05;
// Polish the candidate q, and keep it if its error is at most `enough` and it is new; q is replaced. A singular result of a search
// is dropped if it lies on one continuum with a known one. Returns the Jacobian's smallest
// singular value there (only a lower bound if that is above NEAR_FOLD), or infinity if q is not a solution.
template <class Model>
PART double polish_and_keep(const Model& arm, const Goal<double>& goal, double (&q)[Model::joints], Origin origin, double enough,
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
            if (columns.flags[b] & OTHER && is_joined(arm, goal, q, columns.row(b))) return weak.value;
        }
    }
    if (is_new(arm, goal, columns, q)) keep(columns, 0, q, singular ? OTHER : 0);
    return weak.value;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
