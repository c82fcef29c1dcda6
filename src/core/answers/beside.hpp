// A search beside folds, for arms on which two solutions may have been mistaken for one.
#pragma once

#include "answers/answer.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Distances [rad] from a solution near a fold at which Newton's method starts, half a decade apart.
inline constexpr double BESIDE_FOLD[16] = {0.3,  0.094868,  0.03, 0.0094868, 3e-3, 9.4868e-4, 3e-4, 9.4868e-5,
                                           3e-5, 9.4868e-6, 3e-6, 9.4868e-7, 3e-7, 9.4868e-8, 3e-8, 9.4868e-9};

// Lower bounds on the smallest singular values of the Jacobians at the solutions in a block of columns; 0 in empty columns.
template <class Model>
PART Block least_bounds(const Model& arm, const Goal<Block>& goals, const Columns<Model::joints>& columns, int from) {
    constexpr int N = Model::joints;
    Block q[N], there = 0.0;
    for (Block& each : q) each = 0.0;
    for (int l = 0; l < BLOCK && from + l < columns.many; ++l) {
        if (!columns.valid(from + l)) continue;
        there.set(l, 1.0);
        for (int j = 0; j < N; ++j) q[j].set(l, columns.row(from + l)[j]);
    }
    return there * polish_block<true>(arm, goals, q, {0, 0.0, 0}).least;
}

// Newton's method starts on both sides of a solution near a fold, along the Jacobian's weakest direction. A new solution is kept.
template <class Model>
PART void search_beside_fold(const Model& arm, const Goal<double>& goal, const Goal<Block>& goals, const double (&q)[Model::joints],
                             const Weakest<Model::joints>& fold, const Columns<Model::joints>& columns) {
    constexpr int N = Model::joints;
    for (int k = 0; k < 32; k += BLOCK) {
        Block start[N];
        for (int l = 0; l < BLOCK; ++l) {
            const double away = k + l < 16 ? -BESIDE_FOLD[k + l] : BESIDE_FOLD[k + l - 16];
            for (int j = 0; j < N; ++j) start[j].set(l, advanced(arm, j, q[j], away * fold.direction[j]));
        }
        const Block error = polish_block<true>(arm, goals, start, {20, FINISHED, PATIENCE}).error;
        for (int l = 0; l < BLOCK; ++l) {
            double found[N];
            for (int j = 0; j < N; ++j) found[j] = start[j][l];
            if (error[l] <= CONVERGED && is_new(arm, goal, columns, found))
                keep(columns, 0, found, singular_marks(arm, goal, found, 0));
        }
    }
}

// The same for every solution near a fold. Singular solutions are flagged. Returns whether a solution was near a fold.
template <class Model> PART bool search_beside_folds(const Model& arm, const Goal<double>& goal,
                                                     const Columns<Model::joints>& columns) {
    constexpr int N = Model::joints;
    const Goal<Block> goals = spread<Block>(goal);
    bool near = false;
    for (int from = 0; from < columns.many; from += BLOCK) {
        const Block least = least_bounds(arm, goals, columns, from);
        for (int b = from; b < from + BLOCK && b < columns.many; ++b) {
            if (!columns.valid(b) || least[b - from] > NEAR_FOLD) continue;
            double q[N];
            for (int j = 0; j < N; ++j) q[j] = columns.row(b)[j];
            const Weakest<N> fold = weakest_at(arm, goal, q);
            if (fold.value <= arm.tolerances.singular) columns.flags[b] |= OTHER;
            if (fold.value > NEAR_FOLD) continue;
            near = true;
            search_beside_fold(arm, goal, goals, q, fold, columns);
        }
    }
    return near;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
