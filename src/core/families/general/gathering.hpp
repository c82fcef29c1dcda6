// The solutions that one variant of the elimination finds: Newton's method on the arm as written from each real root.
#pragma once

#include "families/general/complex_roots.hpp"
#include "families/general/eliminant.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// All dimensionless, or in rad; lengths count as shares of the arm's size.
// A root may be real if |log |root|| is below this: rounding and moved axes push double roots off the unit circle by
// half of their digits.
inline constexpr double NEAR_CIRCLE = 0.1;
// A root of a hidden slide is skipped if its cosine is below this: the slide would be longer than 20 times the mean
// distance of the axes.
inline constexpr double FARTHEST = -0.995;

// The roots that may be real, as (cos, sin).
struct RealRoots {
    double c[2 * DEGREE], s[2 * DEGREE];
    int many;
};

STEP RealRoots real_roots(const Complex (&z)[2 * DEGREE], bool hides_slide) {
    RealRoots out = {};
    // |log |z|| < d, by the squares.
    const double near = exponential(2.0 * NEAR_CIRCLE);
    for (const Complex& each : z) {
        const double square = each.re * each.re + each.im * each.im;
        if (!(square < near && square * near > 1.0)) continue;
        const double w = 1.0 / sqrt(square);
        if (hides_slide && each.re * w < FARTHEST) continue;
        out.c[out.many] = each.re * w, out.s[out.many++] = each.im * w;
    }
    return out;
}

// Add the solutions that damped steps reach from the starts without a column.
PART void follow_slowly(const EliminationArm& arm, const Goal<double>& goal, SearchState& search, Candidates& starts,
                        const int (&column)[BLOCK]) {
    for (int l = 0; l < BLOCK; ++l) {
        if (column[l] >= 0) starts.lanes &= ~(1u << l);
    }
    int unused[BLOCK];
    if (starts.lanes) columns_from<true>(arm, goal, search, starts, 40, unused);
}

// Accounts for the determinant's roots off the unit circle, one of each pair.
PART void gather_pairs(const EliminationArm& arm, const EliminationVariant& variant, const Goal<double>& goal, const Equations& A,
                       const Frame<double>& G, const Complex (&z)[2 * DEGREE], SearchState& search) {
    double re[2 * DEGREE], im[2 * DEGREE];
    int many = 0;
    for (const Complex& each : z) {
        if (each.re * each.re + each.im * each.im < 1.0 - HALF_OF_THE_DIGITS) re[many] = each.re, im[many++] = each.im;
    }
    for (int k = many; k < 2 * DEGREE; ++k) re[k] = re[0], im[k] = im[0];
    for (int from = 0; from < many; from += BLOCK) {
        const CBlock hidden = {load<Block>(re + from), load<Block>(im + from)};
        const int rest = many - from;
        CBlock x[SIZE], joints[6];
        null_vectors<CBlock>(A, turn_of(hidden), x);
        complex_joints(variant, G, x, hidden, joints);
        account_for(arm, goal, search, joints, rest >= BLOCK ? (1u << BLOCK) - 1 : (1u << rest) - 1);
    }
}

// Adds the solutions that one variant finds. Returns whether they are certain to be all. Of an arm whose roots are counted: they
// are proven to be. Else: each root that may be real led to a different solution, and no other solution is known; at least one
// solution has to confirm the determinant. of: the equations of the target, or of a pose beside it, from whose roots `slowly` takes
// damped steps to the target.
PART bool gather(const EliminationArm& arm, const EliminationVariant& variant, const Goal<double>& goal, const Eliminant& of,
                 SearchState& search, bool slowly = false) {
    const auto& [G, A, coefficients, error, noise] = of;
    // Noisy harmonics never make the result certain. Of arms whose roots are counted they are not used at all.
    const bool noisy = !(noise < HALF_OF_THE_DIGITS);
    if (noisy && search.provable) return false;
    Complex z[2 * DEGREE];
    self_inversive_roots<2 * DEGREE>(coefficients, z);
    RealRoots roots = real_roots(z, variant.slides[(variant.first + 5) % 6]);
    for (int k = roots.many; k < 2 * DEGREE; ++k) roots.c[k] = roots.c[0], roots.s[k] = roots.s[0];
    // A solution belongs to a root if its hidden joint is this close to it. Rounding and moved axes shift all roots of a cluster
    // about equally, so no root of the cluster is then as far off the circle as NEAR_CIRCLE. Roots of arms near special ones form
    // clusters.
    const double own = search.provable ? NEAR : SAME;
    unsigned owned = 0;
    int settled = 0;
    for (int from = 0; from < roots.many; from += BLOCK) {
        const Block c = load<Block>(roots.c + from), s = load<Block>(roots.s + from);
        const int rest = roots.many - from;
        Candidates candidates;
        candidates.lanes = rest >= BLOCK ? (1u << BLOCK) - 1 : (1u << rest) - 1;
        Block x[SIZE];
        null_vectors<Block>(A, {c, s}, x);
        remaining_values(variant, G, x, c, s, candidates.q);
        for (int j = 0; j < 6; ++j) {
            if (arm.written.slides[j]) candidates.q[j] = candidates.q[j] * (1.0 / arm.scale);
        }
        Candidates slow = candidates;
        int column[BLOCK];
        columns_from<false>(arm, goal, search, candidates, 12, column);
        if (slowly || !search.provable) follow_slowly(arm, goal, search, slow, column);
        for (int l = 0; l < BLOCK; ++l) {
            if (column[l] < 0 || owned >> column[l] & 1) continue;
            double q[6];
            lane_of(candidates.q, l, q);
            const Turn<double> at = hidden_at(arm, variant, q);
            const double dc = at.c - roots.c[from + l], ds = at.s - roots.s[from + l];
            if (dc * dc + ds * ds > own * own) continue;
            owned |= 1u << column[l], ++settled;
        }
    }
    if (search.provable) {
        if (!search.lacks_certificate()) gather_pairs(arm, variant, goal, A, G, z, search);
        return search.account.all();
    }
    return !noisy && settled > 0 && settled == roots.many && settled == search.columns.count();
}

}  // namespace urdf_ik::URDF_IK_LEVEL
