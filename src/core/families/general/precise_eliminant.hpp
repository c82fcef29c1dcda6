// The determinant of a pose's equations in numbers of twice the digits.
//
// Near a special arm the matrix all but loses ranks at every angle, and near a singularity four zeros may lie within 0.01 rad: the
// determinant in doubles is then known to 1e-5 to 1e-10 of its size. Here it is known to their last digits. The rotations of the
// steps and of the target are those nearest to the stored ones, as in certify/precise.hpp.
#pragma once

#include "families/general/eliminant.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Equations (hidden_joint.hpp) in numbers of twice the digits.
struct PreciseEquations {
    Doubled a[6][3][9];
};

// loop_motion() of the arm with the nearest rotations.
PART DoubledMotion precise_loop_motion(const EliminationArm& arm, const Goal<double>& goal, bool reversed) {
    DoubledMotion home = precise(arm.written.step[0], 1.0);
    for (int k = 1; k < 7; ++k) home = composed(home, precise(arm.written.step[k], 1.0));
    DoubledMotion motion = composed(precise(motion_of(goal), 1.0), inverse_of(home));
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) motion.t[i] += motion.R[i][j] * arm.centre[j];
    }
    for (int i = 0; i < 3; ++i) motion.t[i] = arm.scale * (motion.t[i] - arm.centre[i]);
    // Products of rotations have added to what each lacks.
    make_rotation(motion.R);
    return reversed ? inverse_of(motion) : motion;
}

PART void equations(const EliminationVariant& v, const PreciseFactors& rest, const DoubledMotion& motion, PreciseEquations& A) {
    Frame<DoubledBlock> G;
    const auto column = [&](int k) { return Vec<DoubledBlock>{motion.R[0][k], motion.R[1][k], motion.R[2][k]}; };
    G = {{column(0), column(1), column(2)}, {motion.t[0], motion.t[1], motion.t[2]}};
    int columns = 27;
    for (int k = 0; k < v.first; ++k) columns /= 3;
    const int rows = 162 / columns;
    Doubled* a = &A.a[0][0][0];
    for (int from = 0; from < columns; from += BLOCK) {
        DoubledBlock w[LINE], moved[LINE];
        for (int i = 0; i < LINE; ++i) w[i] = load_doubled(v.right[i] + from, rest.right[i] + from);
        move_line(G, w, moved);
        for (int c = from; c < columns && c < from + BLOCK; ++c) {
            for (int r = 0; r < rows; r += BLOCK) {
                DoubledBlock sum = 0.0;
#pragma GCC unroll 1
                for (int i = 0; i < LINE; ++i) {
                    const DoubledBlock factor = Doubled(moved[i].hi[c - from], moved[i].lo[c - from]);
                    sum.add_product(load_doubled(v.left[i] + r, rest.left[i] + r), factor);
                }
                for (int l = 0; l < BLOCK && r + l < rows; ++l) a[(r + l) * columns + c] = {sum.hi[l], sum.lo[l]};
            }
        }
    }
}

// 24 times the determinant.
PART void eliminate_precisely(const EliminationArm& arm, const Goal<double>& goal, OnCircle<Doubled>& out) {
    const EliminationVariant& variant = arm.counter;
    const double reach = length_of_motion(arm, goal);
    const auto& inexact = arm.counter_rest.inexact;
    PreciseEquations A;
    equations(variant, arm.counter_rest, precise_loop_motion(arm, goal, variant.reversed), A);
    Doubled D[SAMPLES];
    determinants<DoubledBlock>(A, D, inexact[0] + reach * (inexact[1] + reach * inexact[2]), out.error);
#pragma GCC unroll 1
    for (int h = 0; h <= DEGREE; ++h) {
        out.re[h] = 0.0, out.im[h] = 0.0;
#pragma GCC unroll 1
        for (int k = 0; k < SAMPLES; ++k) {
            out.re[h] += D[k] * Doubled(WAVES.c[k][h], WAVES.c_rest[k][h]);
            out.im[h] += -(D[k] * Doubled(WAVES.s[k][h], WAVES.s_rest[k][h]));
        }
    }
}

// count_zeros() of the precise determinant, where new roots are certified.
PART bool count_precisely(const EliminationArm& arm, const Goal<double>& goal, SearchState& search) {
    const int reals = search.account.reals;
    if (!counts(arm.counter) || !reals || reals == search.reals_counted) return false;
    if (search.reals_counted < 0) eliminate_precisely(arm, goal, search.determinant);
    search.reals_counted = reals;
    return count_zeros(arm, arm.counter, search.determinant, search);
}

}  // namespace urdf_ik::URDF_IK_LEVEL
