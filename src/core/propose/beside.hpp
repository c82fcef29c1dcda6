// A search beside folds, for arms on which two solutions may have been mistaken for one.
#pragma once

#include "propose/candidates.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Lower bounds on the smallest singular values of the Jacobians at the solutions in a block of columns; 0 in empty columns.
template <class Model>
PART Block least_bounds(const Model& arm, const Goal<Block>& goals, const Columns<Model::joints>& columns, int from) {
    Block q[Model::joints];
    const unsigned lanes = solutions_in(columns, from, q);
    return select(mask_of(lanes), polish_block<true>(arm, goals, q, {0, 0.0, 0}).least, 0.0);
}

// Looks for a second solution beside each one near a fold. Singular solutions are flagged.
template <class Model>
PART void search_beside_folds(const Model& arm, const Goal<double>& goal, const Columns<Model::joints>& columns) {
    for (int b = 0; b < columns.many; ++b) {
        if (!columns.valid(b)) continue;
        const Weakest<Model::joints> weak = weakest_at(arm, goal, columns.row(b));
        if (weak.value <= arm.tolerances.singular) columns.flags[b] |= OTHER;
        if (weak.value <= NEAR_FOLD) keep_beside(arm, goal, columns.row(b), weak, columns);
    }
}

}  // namespace urdf_ik::URDF_IK_LEVEL
