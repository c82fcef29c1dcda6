// All solutions of six joints without a structure to use: elimination to one joint's angle (hidden_joint.hpp), Newton's
// method on the arm as written from what it gives, and a search beside folds. Joints turn or slide.
#pragma once

#include "../blocks.hpp"
#include "complete.hpp"
#include "hidden_joint.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// All dimensionless, or in rad; lengths count as shares of the arm's size.
// A root this close to the unit circle (in its logarithm) may be real: a moved axis, and rounding, push double roots off
// it by half their digits; this close, it should be.
inline constexpr double NEAR_CIRCLE = 0.1, ON_CIRCLE = 0.02;
// Of a hidden slide, the cosine below which a root stands for a length beyond all reach: 20 times the mean distance of the
// axes.
inline constexpr double FARTHEST = -0.995;
// An error from which Newton's method, slow at a double root, may still arrive.
inline constexpr double CLOSE = 1e-4;
// Three roots closer together than this may be taken for each other.
inline constexpr double CROWDED = 0.04;
// Noise of a determinant's harmonics above which it is not trusted.
inline constexpr double LARGEST_NOISE = 1e-7;
// Above this distance [rad] the two solutions of a fold do not hide each other.
inline constexpr double WIDE_FOLD = 0.3;
// Least squared cosine of the angle between the difference of the two solutions of a simple fold and the direction that
// the Jacobian all but loses.
inline constexpr double ALONG_FOLD = 0.9;
// Where no candidate converges, the best is a double root if its error falls below NEARLY; the damping HELD then holds the
// direction in which it is singular, along which rounding would carry the arm about.
inline constexpr double NEARLY = 1e-7, HELD = 1e-6;
// Starts around a candidate that led nowhere; starts all over the joints, for arms with slides, which come to rest when
// the solutions come in pairs, after a quarter of them at the earliest.
inline constexpr int BESIDE_STUCK = 12, ALL_OVER = 160;

// What is known of one pose while it is solved.
struct Search {
    Columns<6> columns;
    double enough;          // error at which a candidate is a solution
    double least[16];       // bound on the smallest singular value of each column's Jacobian; negative: not known yet
    double spare[6], error; // the best of the candidates, and its error
    double stuck[16][6];    // candidates that led nowhere though they should have
    int many_stuck;
};

// A block of joint vectors, and which of its lanes count.
struct Candidates {
    Block q[6];
    unsigned lanes;
};

STEP MaskOf<Block> mask_of(unsigned lanes) {
    double x[BLOCK];
    for (int l = 0; l < BLOCK; ++l) x[l] = lanes >> l & 1;
    return load<Block>(x) > Block(0.0);
}
STEP void lane_of(const Block (&q)[6], int l, double (&out)[6]) {
    for (int j = 0; j < 6; ++j) out[j] = q[j][l];
}

// ---- collecting ------------------------------------------------------------------------------------------------------

// Keep q if it is new. Returns whether it was.
PART bool take(const EliminationArm& arm, const Goal<double>& goal, Search& search, const double (&q)[6], double least,
               int marks = 0) {
    const Columns<6>& columns = search.columns;
    if (!is_new(arm.written, goal, columns, q)) return false;
    int b = 0;
    while (b < columns.many && columns.valid(b)) ++b;
    if (b == columns.many) return false;
    keep(columns, b, q, marks);
    search.least[b] = least;
    return true;
}

STEP Polished<Block> follow(const EliminationArm& arm, const Goal<double>& goal, Block (&q)[6], int rounds, unsigned lanes) {
    return polish<false, Written<6>, Block>(arm.written, spread<Block>(goal), q, {rounds, FINISHED, rounds}, mask_of(lanes));
}
STEP Polished<Block> follow_damped(const EliminationArm& arm, const Goal<double>& goal, Block (&q)[6], int rounds, unsigned lanes) {
    return polish<true, Written<6>, Block>(arm.written, spread<Block>(goal), q, {rounds, FINISHED, PATIENCE}, mask_of(lanes));
}

// Follow the starts, and keep what is new.
PART void take_from(const EliminationArm& arm, const Goal<double>& goal, Search& search, Candidates starts) {
    const Polished<Block> out = follow(arm, goal, starts.q, 20, starts.lanes);
    const unsigned good = bits(out.error <= Block(search.enough)) & starts.lanes;
    for (int l = 0; l < BLOCK; ++l) {
        double q[6];
        lane_of(starts.q, l, q);
        if (good >> l & 1) take(arm, goal, search, q, out.least[l]);
    }
}

// Follow candidates of the elimination; `sure` are those whose root lay on the circle, and should be solutions.
// hasty: those that converge slowly are given up.
template <bool hasty> PART void take_candidates(const EliminationArm& arm, const Goal<double>& goal, Search& search,
                                                const Candidates& starts, unsigned sure) {
    Block q[6], error, least;
    for (int j = 0; j < 6; ++j) q[j] = starts.q[j];
    const auto done = [&](const Polished<Block>& now) {
        error = now.error, least = now.least;
        return bits(error <= Block(search.enough));
    };
    unsigned good = done(follow(arm, goal, q, 12, starts.lanes));
    // Slow at a double root: with damping, from where it is; and from its start, where it should be a solution.
    for (int attempt = hasty ? 2 : 0; attempt < 2; ++attempt) {
        const unsigned again = starts.lanes & ~good & (attempt ? sure : bits(error < Block(CLOSE)));
        if (!again) continue;
        const auto chosen = mask_of(again);
        Block other[6];
        for (int j = 0; j < 6; ++j) other[j] = attempt ? starts.q[j] : q[j];
        const Polished<Block> now = follow_damped(arm, goal, other, 40, again);
        const auto better = chosen & (now.error < error);
        for (int j = 0; j < 6; ++j) q[j] = select(better, other[j], q[j]);
        good = done({select(better, now.error, error), select(better, now.least, least)});
    }
    for (int l = 0; l < BLOCK; ++l) {
        if (!(starts.lanes >> l & 1)) continue;
        double one[6];
        lane_of(q, l, one);
        if (error[l] < search.error) {
            search.error = error[l];
            for (int j = 0; j < 6; ++j) search.spare[j] = one[j];
        }
        const bool taken = (good >> l & 1) && take(arm, goal, search, one, least[l]);
        if (!taken && (sure >> l & 1) && search.many_stuck < 16) { lane_of(starts.q, l, search.stuck[search.many_stuck++]); }
    }
}

// ---- one variant of the elimination ------------------------------------------------------------------------------------

// The motion that the six joints must make together, in the scaled frame of the axes.
STEP Frame<double> loop_motion(const EliminationArm& arm, const Goal<double>& goal, bool reversed) {
    const Frame<double> to = beyond(goal, arm.home_inverse);
    const Vec<double> p = arm.scale * (to.p - vec<double>(arm.centre));
    if (!reversed) return {to.R, p};
    const Rot<double>& R = to.R;
    return {{{R.x.x, R.y.x, R.z.x}, {R.x.y, R.y.y, R.z.y}, {R.x.z, R.y.z, R.z.z}}, {-dot(R.x, p), -dot(R.y, p), -dot(R.z, p)}};
}

using Sixteen = Row<2 * DEGREE>;

// Whether three roots, one of which may be real, are so close that rounding can move them about.
STEP bool crowded(const double (&x)[2 * DEGREE], const double (&y)[2 * DEGREE]) {
    const Sixteen a = load<Sixteen>(x), b = load<Sixteen>(y), square = a * a + b * b;
    Sixteen close = 0.0;
    for (int k = 0; k < 2 * DEGREE; ++k) {
        const Sixteen dx = a - x[k], dy = b - y[k];
        close += select(dx * dx + dy * dy < Sixteen(CROWDED * CROWDED), Sixteen(1.0), 0.0);
    }
    return any((close > Sixteen(2.0)) & (square > Sixteen(0.81)) & (square < Sixteen(1.21)));
}

// Real roots, and nearly real ones, as (cos, sin).
struct RealRoots {
    double c[2 * DEGREE], s[2 * DEGREE];
    int many, expected;
    unsigned sure;
    bool crowded;
};

STEP RealRoots real_roots(const Complex (&coefficients)[2 * DEGREE + 1], bool hides_slide) {
    Complex z[2 * DEGREE];
    double x[2 * DEGREE], y[2 * DEGREE];
    self_inversive_roots<2 * DEGREE>(coefficients, z);
    RealRoots out = {};
    // |log |z|| < d, by the squares.
    const double near = __builtin_exp(2.0 * NEAR_CIRCLE), on = __builtin_exp(2.0 * ON_CIRCLE);
    for (int k = 0; k < 2 * DEGREE; ++k) {
        x[k] = z[k].re, y[k] = z[k].im;
        const double square = x[k] * x[k] + y[k] * y[k];
        if (!(square < near && square * near > 1.0)) continue;
        const double w = 1.0 / sqrt(square);
        if (hides_slide && x[k] * w < FARTHEST) continue;
        const bool sure = square < on && square * on > 1.0;
        out.sure |= unsigned(sure) << out.many, out.expected += sure;
        out.c[out.many] = x[k] * w, out.s[out.many++] = y[k] * w;
    }
    out.crowded = crowded(x, y);
    return out;
}

// Add the solutions that one variant finds. Returns whether it gives cause for doubt: where the determinant was lost in
// rounding, where more roots look real than solutions came of them, where roots may have been taken for each other.
// hasty: a determinant that is lost in rounding is not looked at any further, nor candidates that converge slowly.
template <bool hasty> PART bool gather(const EliminationArm& arm, const EliminationVariant& variant, const Goal<double>& goal,
                                       Search& search) {
    Equations A;
    double D[SAMPLES];
    Complex coefficients[2 * DEGREE + 1];
    const Frame<double> G = loop_motion(arm, goal, variant.reversed);
    equations(variant, G, A);
    determinants(A, D);
    const bool noisy = !(harmonics(D, coefficients) < LARGEST_NOISE);
    if (hasty && noisy) return true;
    RealRoots roots = real_roots(coefficients, variant.slides[(variant.first + 5) % 6]);
    search.many_stuck = 0;
    for (int k = roots.many; k < 2 * DEGREE; ++k) roots.c[k] = roots.c[0], roots.s[k] = roots.s[0];
    for (int from = 0; from < roots.many; from += BLOCK) {
        const Block c = load<Block>(roots.c + from), s = load<Block>(roots.s + from);
        const int rest = roots.many - from;
        Candidates candidates;
        candidates.lanes = rest >= BLOCK ? (1u << BLOCK) - 1 : (1u << rest) - 1;
        Block x[SIZE];
        null_vectors(A, c, s, x);
        remaining_values(variant, G, x, c, s, candidates.q);
        for (int j = 0; j < 6; ++j) {
            if (arm.written.slides[j]) candidates.q[j] = candidates.q[j] * (1.0 / arm.scale);
        }
        take_candidates<hasty>(arm, goal, search, candidates, roots.sure >> from & candidates.lanes);
    }
    return noisy || search.columns.count() < roots.expected || roots.crowded;
}

// ---- beside folds --------------------------------------------------------------------------------------------------------

// How far along x, which J all but loses, a fold has its other solution [rad].
// To second order the pose moves by s J x + s^2 / 2 c along it. Derivative of the geometric Jacobian: Hourtash 2005.
STEP double fold_width(const Six<double> (&J)[6], const double (&x)[6]) {
    Vec<double> linear = {0.0, 0.0, 0.0}, angular = {0.0, 0.0, 0.0};
    Six<double> w = {};
    for (int k = 0; k < 6; ++k) {
        const Vec<double> v = {J[k][0], J[k][1], J[k][2]}, turn = {J[k][3], J[k][4], J[k][5]};
        for (int i = 0; i <= k; ++i) {
            const Vec<double> other = {J[i][3], J[i][4], J[i][5]};
            linear = linear + (x[i] * x[k] * (i == k ? 1.0 : 2.0)) * cross(other, v);
            angular = angular + (x[i] * x[k]) * cross(other, turn);
        }
        w = less(w, -x[k], J[k]);
    }
    const Six<double> c = {{linear.x, linear.y, linear.z, angular.x, angular.y, angular.z}};
    return 2.0 * dot(w, w) / (abs(dot(w, c)) + TINY);
}

// Whether another solution lies beside column b along the unit vector x, some width [rad] away.
STEP bool has_partner(const EliminationArm& arm, const Columns<6>& columns, int b, const double (&x)[6], double width) {
    for (int k = 0; k < columns.many; ++k) {
        if (k == b || !columns.valid(k)) continue;
        double along = 0.0, square = 0.0;
        for (int j = 0; j < 6; ++j) {
            const double apart = gap(arm.written, j, columns.row(k)[j], columns.row(b)[j]);
            along += apart * x[j], square += apart * apart;
        }
        if (square < 9.0 * width * width && along * along > ALONG_FOLD * square) return true;
    }
    return false;
}

// The bounds on smallest singular values that are not known yet.
PART void measure(const EliminationArm& arm, const Goal<double>& goal, Search& search) {
    const Columns<6>& columns = search.columns;
    for (int from = 0; from < columns.many; from += BLOCK) {
        Block q[6];
        unsigned lanes = 0;
        for (int l = 0; l < BLOCK; ++l) {
            const int b = from + l;
            const bool open = b < columns.many && columns.valid(b) && search.least[b] < 0.0;
            lanes |= unsigned(open) << l;
            for (int j = 0; j < 6; ++j) q[j].set(l, open ? columns.row(b)[j] : 0.0);
        }
        if (!lanes) continue;
        const Block least = follow(arm, goal, q, 0, lanes).least;
        for (int l = 0; l < BLOCK; ++l) {
            if (lanes >> l & 1) search.least[from + l] = least[l];
        }
    }
}

// Distances [rad] from 0.3 to 1e-8 at which Newton's method starts beside a fold, half a decade apart.
inline constexpr double DISTANCES[16] = {0.3,  0.094868,  0.03, 0.0094868, 3e-3, 9.4868e-4, 3e-4, 9.4868e-5,
                                         3e-5, 9.4868e-6, 3e-6, 9.4868e-7, 3e-7, 9.4868e-8, 3e-8, 9.4868e-9};

// Find the partners of solutions that lie next to a fold; flag the singular ones. Returns whether it looked.
// Where folds are simple a solution whose partner is known, or too far off to hide, is passed over; arms whose folds come
// in clusters have more solutions there than the two.
PART bool search_beside(const EliminationArm& arm, const Goal<double>& goal, Search& search, bool simple) {
    const Columns<6>& columns = search.columns;
    bool looked = false;
    measure(arm, goal, search);
    for (int b = 0; b < columns.many; ++b) {
        if (!columns.valid(b) || search.least[b] > NEAR_FOLD) continue;
        double q[6];
        for (int j = 0; j < 6; ++j) q[j] = columns.row(b)[j];
        Six<double> J[6], factored[6];
        error_and_jacobian(arm.written, goal, q, J);
        for (int j = 0; j < 6; ++j) factored[j] = J[j];
        const Weakest<6> fold = weakest(factored);
        if (fold.value <= arm.written.tolerances.singular) columns.flags[b] |= OTHER;
        if (fold.value > NEAR_FOLD) continue;
        if (simple) {
            const double width = fold_width(J, fold.direction);
            if (width > WIDE_FOLD || has_partner(arm, columns, b, fold.direction, width)) continue;
        }
        looked = true;
        for (int k = 0; k < 32; k += BLOCK) {
            Candidates starts;
            starts.lanes = (1u << BLOCK) - 1;
            for (int l = 0; l < BLOCK; ++l) {
                const double distance = k + l < 16 ? -DISTANCES[k + l] : DISTANCES[k + l - 16];
                for (int j = 0; j < 6; ++j) starts.q[j].set(l, advanced(arm.written, j, q[j], distance * fold.direction[j]));
            }
            take_from(arm, goal, search, starts);
        }
    }
    return looked;
}

// ---- starts where nothing else helps ---------------------------------------------------------------------------------------

// Fixed numbers in [-1, 1) that look random (the linear congruence of C's standard example).
struct Scatter {
    unsigned seed;
    STEP double next() {
        seed = (seed * 1103515245u + 12345u) & 0x7fffffffu;
        return seed / 1073741824.0 - 1.0;
    }
};

// From 1e-2 to 1e-6 rad beside the candidates that led nowhere.
PART void search_around_stuck(const EliminationArm& arm, const Goal<double>& goal, Search& search) {
    constexpr double width[3] = {1e-2, 1e-4, 1e-6};
    const int all = search.many_stuck * BESIDE_STUCK;
    for (int from = 0; from < all; from += BLOCK) {
        Candidates starts;
        starts.lanes = 0;
        for (int l = 0; l < BLOCK; ++l) {
            const int at = from + l < all ? from + l : from, k = 1 + at % BESIDE_STUCK;
            starts.lanes |= unsigned(from + l < all) << l;
            Scatter scatter = {12345u + 7919u * k};
            for (int j = 0; j < 6; ++j) {
                const double by = width[k % 3] * (k < 7 ? 1.0 : 0.3) * scatter.next();
                starts.q[j].set(l, advanced(arm.written, j, search.stuck[at / BESIDE_STUCK][j], by));
            }
        }
        take_from(arm, goal, search, starts);
    }
}

// From all over the joints' values, until the solutions come in pairs. Where the arm is singular and a singular solution
// is known, another one belongs to the same continuum.
PART void search_all_over(const EliminationArm& arm, const Goal<double>& goal, Search& search) {
    Scatter scatter = {12345u};
    const double singular = arm.written.tolerances.singular;
    for (int from = 0; from < ALL_OVER; from += BLOCK) {
        Block q[6];
        for (int l = 0; l < BLOCK; ++l) {
            for (int j = 0; j < 6; ++j) q[j].set(l, scatter.next() * (arm.written.slides[j] ? arm.written.size : PI));
        }
        const Polished<Block> out = follow_damped(arm, goal, q, 30, (1u << BLOCK) - 1);
        const unsigned good = bits(out.error <= Block(search.enough));
        for (int l = 0; l < BLOCK; ++l) {
            if (!(good >> l & 1)) continue;
            double one[6];
            lane_of(q, l, one);
            bool known = false;
            for (int b = 0; b < search.columns.many; ++b) known |= (search.columns.flags[b] & OTHER) != 0;
            const bool stiff = weakest_at(arm.written, goal, one).value > singular;
            if (stiff || !known) take(arm, goal, search, one, out.least[l], stiff ? 0 : OTHER);
        }
        const int count = search.columns.count();
        if (from + BLOCK >= ALL_OVER / 4 && count > 0 && count % 2 == 0) break;
    }
}

// ---- the whole ---------------------------------------------------------------------------------------------------------------

STEP Search new_search(const EliminationArm& arm, const Goal<double>& goal, const Columns<6>& columns) {
    Search search;
    search.columns = columns, search.error = __builtin_inf(), search.many_stuck = 0;
    // A slide far out carries its rounding to the tip.
    search.enough = CONVERGED * (arm.any_slide ? 1.0 + sqrt(dot(goal.p, goal.p)) / arm.written.size : 1.0);
    for (double& each : search.least) each = -1.0;
    return search;
}

// gather without help from the solutions that are known; missing one of them is cause for doubt too.
PART bool gather_anew(const EliminationArm& arm, const EliminationVariant& variant, const Goal<double>& goal, Search& search) {
    double q[6 * 16];
    std::uint8_t flags[16];
    const Columns<6> columns = {q, flags, 16};
    columns.clear();
    Search fresh = new_search(arm, goal, columns);
    bool doubt = gather<false>(arm, variant, goal, fresh);
    const auto row = [](const Columns<6>& from, int b, double (&to)[6]) {
        for (int j = 0; j < 6; ++j) to[j] = from.row(b)[j];
    };
    double one[6];
    for (int b = 0; b < search.columns.many && !doubt; ++b) {
        row(search.columns, b, one);
        doubt = search.columns.valid(b) && is_new(arm.written, goal, columns, one);
    }
    for (int b = 0; b < 16; ++b) {
        row(columns, b, one);
        if (columns.valid(b)) take(arm, goal, search, one, fresh.least[b]);
    }
    search.error = fresh.error, search.many_stuck = fresh.many_stuck;
    for (int j = 0; j < 6; ++j) search.spare[j] = fresh.spare[j];
    for (int k = 0; k < fresh.many_stuck; ++k) {
        for (int j = 0; j < 6; ++j) search.stuck[k][j] = fresh.stuck[k][j];
    }
    return doubt;
}

// Add to the columns (16) the solutions of that pose which they lack.
// from_scratch: false where what they hold comes from a closed form, of an arm whose folds are simple: it then tests the
// elimination, and a first look that misses none of it is believed.
void complete(const EliminationArm& arm, const Goal<double>& goal, const Columns<6>& columns, bool from_scratch) {
    Search search = new_search(arm, goal, columns);
    bool sure = false, beside = false;
    for (int v = 0; v < arm.variants; ++v) {
        const bool known = !from_scratch, last = v + 1 == arm.variants;
        const bool doubt =
            known && v == 0 ? gather_anew(arm, arm.variant[v], goal, search) : gather<false>(arm, arm.variant[v], goal, search);
        sure = !doubt || (known && sure);
        if (v == 0 || last) beside = search_beside(arm, goal, search, known);
        // Solutions come in pairs; next to a fold one opinion is not enough.
        if (sure && columns.count() % 2 == 0 && (v > 0 || !beside)) break;
        if (last) search_around_stuck(arm, goal, search);
    }
    if (arm.any_slide && !sure && (columns.count() == 0 || columns.count() % 2 == 1)) search_all_over(arm, goal, search);
    if (columns.count() == 0 && search.error < NEARLY) {
        const Course held = {8, FINISHED, LONG_PATIENCE, HELD};
        if (polish_one<true>(arm.written, goal, search.spare, held).error <= arm.written.tolerances.reach) {
            keep(columns, 0, search.spare, OTHER);
        }
    }
}

struct General6 {
    using Arm = EliminationArm;
    static constexpr int branches = 16;
    static STEP void solve(const Arm& arm, const Goal<double>& goal, const Reference<6>&, const Columns<6>& columns) {
        complete(arm, goal, columns, true);
        sort(columns);
    }
};

// See EliminationSolvers. A variant that the noise of its determinant rules out at a pose counts as finding nothing there.
PART void try_variants(const EliminationArm& arm, const EliminationVariant* variants, int many, const double* T, long m,
                       const EliminationTrial& out) {
    double q[EliminationTrial::most][6 * 16];
    std::uint8_t flags[EliminationTrial::most][16];
    for (long i = 0; i < m; ++i) {
        const Goal<double> goal = goal_of(T + 16 * i);
        Search search[EliminationTrial::most];
        long most = 0;
        for (int v = 0; v < many; ++v) {
            const Columns<6> columns = {q[v], flags[v], 16};
            columns.clear();
            search[v] = new_search(arm, goal, columns);
            const bool doubt = gather<true>(arm, variants[v], goal, search[v]);
            out.counts[m * v + i] = columns.count();
            out.doubts[m * v + i] = doubt || columns.count() % 2 == 1;
            most = columns.count() > most ? columns.count() : most;
        }
        // Those that found less than another did may still find it beside a fold.
        for (int v = 0; v < many; ++v) {
            if (out.counts[m * v + i] == most || out.counts[m * v + i] == 0) continue;
            search_beside(arm, goal, search[v], false);
            const long count = search[v].columns.count();
            out.counts[m * v + i] = count < most ? count : most;
        }
    }
}

}  // namespace urdf_ik::URDF_IK_LEVEL
