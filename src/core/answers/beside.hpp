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
    Rows<Model::rows, Block> J[N];
    const Error<Block, Model::rows> e = error_and_jacobian(arm, goals, q, J);
    return there * least_squares<false>(J, e.twist, Block(0.0)).least;
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
        const Block error = polish<true>(arm, goals, start, {20, FINISHED, PATIENCE}).error;
        for (int l = 0; l < BLOCK; ++l) {
            double found[N];
            for (int j = 0; j < N; ++j) found[j] = start[j][l];
            if (error[l] <= CONVERGED && is_new(arm, goal, columns, found))
                add(arm, goal, columns, 0, found, singular_marks(arm, goal, found, 0));
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

// A valley is a curve whose points almost reach the goal, and along which the Jacobian nearly loses a rank. The length of a step
// along it [rad], the number of steps, a damping that suppresses motion in the weak direction, the singular value at which the
// valley ends, and the largest error of its points.
inline constexpr double STRIDE = 0.06, HOLDING = 3e-3, NO_LONGER_WEAK = 3e-2, OUT_OF_VALLEY = 1e-2;
inline constexpr int STRIDES = 128;
// If a solution's singular value is below this, its valley is followed however many solutions are known.
inline constexpr double IN_A_VALLEY = 1e-5;

// Newton's method from a point in a valley. A new solution is kept.
template <class Model>
PART void polish_in_valley(const Model& arm, const Goal<double>& goal, double (&q)[Model::joints],
                           const Columns<Model::joints>& columns) {
    if (polish_one<true>(arm, goal, q, {60, FINISHED, LONG_PATIENCE}).error <= CONVERGED && is_new(arm, goal, columns, q)) {
        add(arm, goal, columns, 0, q, singular_marks(arm, goal, q, 0));
    }
}

// Search for solutions along the valley through `from`, in one direction. Damped steps remove the error across the valley, so the
// remaining errors of its points lie along one direction. A solution lies between two points whose errors are opposite; next to
// `from` the error is opposite to the Jacobian's image of the step. Two solutions, or a double root, may lie about a point with a
// smaller error than its neighbours: Newton's method starts from both of these. `passed`: a bit for each column whose solution
// lies in this valley. Returns whether the valley is closed.
template <class Model>
PART bool walk_valley(const Model& arm, const Goal<double>& goal, const double* from, double way,
                      const Columns<Model::joints>& columns, unsigned& passed) {
    constexpr int N = Model::joints;
    double q[N], last[N], older[N], along[N], sizes[2] = {};  // of the errors at `last` and at `older`
    for (int j = 0; j < N; ++j) q[j] = last[j] = from[j];
    Rows<Model::rows, double> error = {}, before = {}, J[N];
    error_and_jacobian(arm, goal, q, J);
    Weakest<N> weak = weakest(J);
    for (int j = 0; j < N; ++j) {
        along[j] = way * weak.direction[j];
        for (int i = 0; i < Model::rows; ++i) error[i] -= STRIDE * along[j] * J[j][i];
    }
    const double slope = sqrt(dot(error, error));
    for (int k = 0; k < STRIDES && weak.value < NO_LONGER_WEAK; ++k) {
        Error<double, Model::rows> left = {};
        for (int j = 0; j < N; ++j) older[j] = last[j], last[j] = q[j], q[j] = advanced(arm, j, q[j], STRIDE * along[j]);
        for (int round = 0; round < 3; ++round) {
            left = error_and_jacobian(arm, goal, q, J);
            if (round == 2) break;
            const Solved<N, double> step = least_squares<true, N, Model::rows>(J, left.twist, HOLDING);
            for (int j = 0; j < N; ++j) q[j] = advanced(arm, j, q[j], step.x[j]);
        }
        if (!(left.size < OUT_OF_VALLEY)) return false;
        before = error, error = left.twist;
        const double size = sqrt(dot(error, error));
        if (dot(before, error) < 0.0) {
            // By a line through both errors; from a solution on, by a parabola.
            const double share = (k == 0 ? slope : sizes[0]) / ((k == 0 ? slope : sizes[0]) + size);
            double found[N];
            for (int j = 0; j < N; ++j) found[j] = advanced(arm, j, last[j], share * gap(arm, j, q[j], last[j]));
            polish_in_valley(arm, goal, found, columns);
        } else if (k > 1 && sizes[0] < min(sizes[1], size)) {
            double found[N];
            for (int j = 0; j < N; ++j) found[j] = q[j];
            polish_in_valley(arm, goal, older, columns), polish_in_valley(arm, goal, found, columns);
        }
        sizes[1] = sizes[0], sizes[0] = size;
        const auto is_here = [&](const double* other) { return distance(arm, q, other) < STRIDE; };
        if (k > 2 && is_here(from)) return true;
        for (int c = 0; c < columns.many; ++c) {
            if (columns.valid(c) && is_here(columns.row(c))) passed |= 1u << c;
        }
        weak = weakest(J);
        double same = 0.0;
        for (int j = 0; j < N; ++j) same += along[j] * weak.direction[j];
        for (int j = 0; j < N; ++j) along[j] = (same < 0.0 ? -1.0 : 1.0) * weak.direction[j];
    }
    return false;
}

// Walk the valleys of all solutions whose smallest singular value is at most `weak`, in both directions unless a valley is closed.
template <class Model>
PART void walk_valleys(const Model& arm, const Goal<double>& goal, double weak, const Columns<Model::joints>& columns) {
    unsigned passed = 0;
    for (int b = 0; b < columns.many; ++b) {
        if (!columns.valid(b) || passed >> b & 1) continue;
        double q[Model::joints];
        for (int j = 0; j < Model::joints; ++j) q[j] = columns.row(b)[j];
        if (weakest_at(arm, goal, q).value > weak) continue;
        if (!walk_valley(arm, goal, q, 1.0, columns, passed)) walk_valley(arm, goal, q, -1.0, columns, passed);
    }
}

}  // namespace urdf_ik::URDF_IK_LEVEL
