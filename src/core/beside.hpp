// A search beside folds, for arms of which two solutions may have been taken for one.
#pragma once

#include "answer.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A solution whose Jacobian has a smaller singular value may have a second one next door (rad, shares of the size).
inline constexpr double SECOND_NEXT_DOOR = 5e-3;
// Distances [rad] at which Newton's method starts beside it, half a decade apart.
inline constexpr double BESIDE_FOLD[16] = {0.3,  0.094868,  0.03, 0.0094868, 3e-3, 9.4868e-4, 3e-4, 9.4868e-5,
                                           3e-5, 9.4868e-6, 3e-6, 9.4868e-7, 3e-7, 9.4868e-8, 3e-8, 9.4868e-9};

// Newton's method starts on both sides of every solution near a fold, along what the Jacobian all but loses; what it finds
// is kept if it is new. Solutions that are singular are flagged. Returns whether there was one near a fold.
template <class Model> PART bool search_beside_folds(const Model& arm, const Goal<double>& goal,
                                                     const Columns<Model::joints>& columns) {
    constexpr int N = Model::joints;
    const Goal<Block> goals = spread<Block>(goal);
    bool near = false;
    for (int b = 0; b < columns.many; ++b) {
        if (!columns.valid(b)) continue;
        double q[N];
        for (int j = 0; j < N; ++j) q[j] = columns.row(b)[j];
        const Weakest<N> fold = weakest_at(arm, goal, q);
        if (fold.value <= arm.tolerances.singular) columns.flags[b] |= OTHER;
        if (fold.value > SECOND_NEXT_DOOR) continue;
        near = true;
        for (int k = 0; k < 32; k += BLOCK) {
            Block start[N];
            for (int l = 0; l < BLOCK; ++l) {
                const double away = k + l < 16 ? -BESIDE_FOLD[k + l] : BESIDE_FOLD[k + l - 16];
                for (int j = 0; j < N; ++j) start[j].set(l, advanced(arm, j, q[j], away * fold.direction[j]));
            }
            const Block zero = 0.0;
            const Block error = polish<true, Model, Block>(arm, goals, start, {20, FINISHED, PATIENCE}, zero <= zero).error;
            for (int l = 0; l < BLOCK; ++l) {
                double found[N];
                for (int j = 0; j < N; ++j) found[j] = start[j][l];
                if (error[l] <= CONVERGED && is_new(arm, goal, columns, found))
                    keep(columns, 0, found, singular_marks(arm, goal, found, 0));
            }
        }
    }
    return near;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
