// What is known while one pose is solved: the columns with solutions so far, the account of certified roots, and joint vectors that
// led to neither.
#pragma once

#include "certify/account.hpp"
#include "certify/circle.hpp"
#include "certify/precise.hpp"
#include "families/blocks.hpp"
#include "families/general/elimination_arm.hpp"
#include "referee/on_curve.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Rounds of Newton's method to a complex solution: moved axes are up to 1e-5 off, and convergence is quadratic.
inline constexpr int ROUNDS_TO_PAIRS = 6;
// Roots with e^(sum of |imaginary parts|) above FAR_FROM_REAL, whose bound on Newton's step is below CONVERGING [rad], are
// certified with twice the digits where doubles fail.
inline constexpr double FAR_FROM_REAL = 100.0, CONVERGING = 0.1;

// The state of solving one pose.
struct SearchState {
    Columns<6> columns;
    double enough;  // a candidate with at most this error is a solution
    bool provable = false;  // whether complex roots are counted
    OnCircle<Doubled> determinant;  // with twice the digits, once reals_counted >= 0: real roots when its zeros were counted
    int reals_counted = -1;
    bool certifies = false;  // whether real roots are certified: all joints turn
    int zeros = -1;  // real roots that there can be at most; -1 where that is open
    Loop loop = {};
    Account account = {};

    // Whether as many different real roots are certified as there can be.
    STEP bool counted() const { return zeros >= 0 && zeros == account.reals; }
    // Whether a solution has no certificate, as singular ones have none: then no count of certified roots is complete.
    STEP bool lacks_certificate() const { return account.reals < columns.count(); }
};

// A block of joint vectors, and a bit for each lane in use.
struct Candidates {
    Block q[6];
    unsigned lanes;
};

STEP void lane_of(const Block (&q)[6], int l, double (&out)[6]) {
    for (int j = 0; j < 6; ++j) out[j] = q[j][l];
}

// Whether the solver counts certified roots: six turning joints, and all sixteen solutions of a pose can be found.
STEP bool is_provable(const EliminationArm& arm) { return !arm.near && !arm.any_slide; }

STEP SearchState search_state(const EliminationArm& arm, const Goal<double>& goal, const Columns<6>& columns, double enough) {
    SearchState search;
    search.columns = columns, search.enough = enough;
    search.provable = is_provable(arm);
    search.certifies = !arm.any_slide;
    if (search.certifies) search.loop = loop_of(arm.written, goal);
    return search;
}

// ---- collecting ------------------------------------------------------------------------------------------------------

// The column of q, which is kept if it is new; -1 if all columns are taken. least: a lower bound on the smallest singular value of
// its Jacobian.
PART int column_of(const EliminationArm& arm, const Goal<double>& goal, SearchState& search, const double (&q)[6], double least) {
    const Columns<6>& columns = search.columns;
    if (is_new(arm.written, goal, columns, q)) {
        const int b = columns.vacant();
        if (b >= 0) keep(columns, b, q, least < NEAR_FOLD ? singular_marks(arm.written, goal, q, 0) : 0);
        return b;
    }
    const int nearest = nearest_column(arm.written, columns, q);
    // Next to a singularity, keep only the most accurate approximation of the root.
    if (distance(arm.written, q, columns.row(nearest)) > arm.written.tolerances.duplicate &&
        missed_by(arm.written, goal, q) < 0.1 * missed_by(arm.written, goal, columns.row(nearest))) {
        const int marks = columns.flags[nearest] & ~VALID;
        columns.clear(nearest);
        if (!is_new(arm.written, goal, columns, q)) return column_of(arm, goal, search, q, least);
        keep(columns, nearest, q, marks);
    }
    return nearest;
}

// Certifies a block of solutions; least: bounds on the smallest singular value.
PART void account_for(SearchState& search, const Block (&q)[6], unsigned lanes, const Block& least) {
    const Certificate c = certify_real(search.loop, q);
    for (unsigned rest = bits(c.holds) & lanes; rest; rest &= rest - 1) {
        const int l = __builtin_ctz(rest);
        RealRoot root = {{}, c.inner[l], c.outer[l], least[l]};
        lane_of(q, l, root.q);
        add_real(search.account, root);
    }
}

// The columns of the solutions that Newton's method reaches from the starts; -1 for starts that reach no solution.
template <bool damped>
PART void columns_from(const EliminationArm& arm, const Goal<double>& goal, SearchState& search, Candidates& starts, int rounds,
                       int (&column)[BLOCK]) {
    const Course course = {rounds, FINISHED, damped ? PATIENCE : rounds};
    const Polished<Block> out = polish_block<damped>(arm.written, spread<Block>(goal), starts.q, course, mask_of(starts.lanes));
    const unsigned good = bits(out.error <= Block(search.enough)) & starts.lanes;
    if (search.certifies && good) account_for(search, starts.q, good, out.least);
    for (int l = 0; l < BLOCK; ++l) {
        double q[6];
        lane_of(starts.q, l, q);
        column[l] = good >> l & 1 ? column_of(arm, goal, search, q, out.least[l]) : -1;
    }
}

// Certifies the solutions that Newton's method reaches from a block of complex joints, and adds them to the account. A real one is
// polished in real numbers, as every solution.
PART void account_for(const EliminationArm& arm, const Goal<double>& goal, SearchState& search, CBlock (&z)[6], unsigned lanes) {
    Growth growth;
    Certificate c = certify_complex(search.loop, z, lanes, ROUNDS_TO_PAIRS, growth);
    // Far from real, rounding alone may fail a certificate.
    const unsigned far = lanes & bits((growth.all > Block(FAR_FROM_REAL)) & (c.eta < Block(CONVERGING))) & ~bits(c.holds);
    if (far) {
        Growth own;
        CBlock at[6];
        for (int k = 0; k < 6; ++k) at[k] = z[k];
        const Certificate more = certify_precisely(search.loop, precise_loop(arm.written, goal), at, far, own);
        const auto better = mask_of(far) & more.holds;
        for (int k = 0; k < 6; ++k) z[k] = select<Block>(better, at[k], z[k]);
        c.holds = c.holds | better, c.inner = select(better, more.inner, c.inner), c.outer = select(better, more.outer, c.outer);
        growth.imaginary = select(better, own.imaginary, growth.imaginary);
    }
    Candidates starts = {{}, 0};
    for (unsigned rest = bits(c.holds) & lanes; rest; rest &= rest - 1) {
        const int l = __builtin_ctz(rest);
        if (growth.imaginary[l] > c.inner[l]) {
            PairOfRoots root = {{}, c.inner[l], c.outer[l]};
            for (int k = 0; k < 6; ++k) root.z[k][0] = z[k].re[l], root.z[k][1] = z[k].im[l];
            add_pair(search.account, root);
            continue;
        }
        starts.lanes |= 1u << l;
        // A root and its conjugate in the ball that holds one are the same, a real one.
        if (!(far >> l & 1) || !(c.inner[l] + 2.0 * growth.imaginary[l] < c.outer[l])) continue;
        RealRoot root = {{}, c.inner[l] + growth.imaginary[l], c.outer[l] - growth.imaginary[l], 0.0};
        for (int k = 0; k < 6; ++k) root.q[k] = atan2(z[k].im[l], z[k].re[l]);
        add_real(search.account, root);
    }
    if (!starts.lanes) return;
    for (int k = 0; k < 6; ++k) starts.q[k] = atan2(z[k].im, z[k].re);
    int column[BLOCK];
    columns_from<false>(arm, goal, search, starts, 12, column);
}

// The columns that approximate certified real roots stay, the others go, and roots without one get one.
PART void keep_certified(const EliminationArm& arm, const Goal<double>& goal, const SearchState& search) {
    const Account& account = search.account;
    const Columns<6>& columns = search.columns;
    unsigned owned = 0;
    for (int b = 0; b < columns.many; ++b) {
        if (!columns.valid(b)) continue;
        int own = -1;
        for (int i = 0; i < account.reals; ++i) {
            if (distance(arm.written, columns.row(b), account.real[i].q) <= account.real[i].outer) own = i;
        }
        if (own < 0 || owned >> own & 1) columns.clear(b);
        else owned |= 1u << own;
    }
    for (int i = 0; i < account.reals; ++i) {
        if (owned >> i & 1) continue;
        const RealRoot& root = account.real[i];
        keep(columns, 0, root.q, root.least < NEAR_FOLD ? singular_marks(arm.written, goal, root.q, 0) : 0);
    }
}

}  // namespace urdf_ik::URDF_IK_LEVEL
