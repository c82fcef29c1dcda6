// All solutions of six joints without a special structure. Joints turn or slide.
//
// First the elimination to one joint's angle (hidden_joint.hpp): Newton's method on the arm as written starts from each
// real root. This is fast, and almost always complete if the roots are well separated. At poses with round numbers they
// often are not. The result is accepted if each root that may be real led to a different solution, with the hidden
// joint at that root. Otherwise continuation follows all complex solutions of a known pose to this one
// (continuation.hpp) and counts them: if as many regular solutions arrive as started, none is missing.
#pragma once

#include "answers/beside.hpp"
#include "answers/referee.hpp"
#include "families/general/complete.hpp"
#include "families/general/continuation.hpp"
#include "families/general/gathering.hpp"
#include "families/general/precise_eliminant.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// All dimensionless, or in rad; lengths count as shares of the arm's size.
// The end of a path is not real if an angle's imaginary part is above this: at regular ends, and at singular ends.
inline constexpr double IMAGINARY = 1e-4, IMAGINARY_SINGULAR = 0.05;
// Paths run from s = 1 to s = 0. A path that stops above this s was lost; one that stops below it ends at a singular solution.
inline constexpr double AT_SINGULAR = 1e-10;
// Attempts at continuation, each from another known pose; and starts all over the joint space of an arm with slides if none of them
// decides.
inline constexpr int ATTEMPTS = 4, ALL_OVER = 160;

// ---- continuation --------------------------------------------------------------------------------------------------------

// What the ends of all paths show. regular: each path ended at a different regular solution, or was lost far from real.
// settled: some ended at singular solutions that were found or are not real. lost: a solution may be missing, for
// example because two ends led to one solution.
enum class Arrived { lost, settled, regular };

// The classification of a path's end.
struct PathEnd {
    bool smooth;    // regular and real
    bool rough;     // a member of a continuum, or a double root: its real part becomes a start
    bool distant;   // lost far from real; the real part becomes a start, for real members of a continuum
    bool accounts;  // the path is accounted for without a solution from the start
};

STEP PathEnd path_end(const Written<6>& arm, const PathEnds& ends, int i) {
    const bool regular = ends.regular[i], singular = !regular && ends.left[i] < AT_SINGULAR;
    const double off = imaginary_part(arm, ends.q[i]);
    const bool real = off < (regular ? IMAGINARY : IMAGINARY_SINGULAR), distant = !regular && off > DISTANT;
    const bool rough = !(regular && real) && (regular ? ends.weak[i] : singular);
    return {regular && real, rough, distant, regular || distant || (singular && !real)};
}

// Whether a regular solution was found at which no path ended. The known poses then lack a path, and others may be
// missing.
STEP bool is_stranger(const Columns<6>& columns, unsigned owned) {
    for (int b = 0; b < columns.many; ++b) {
        if (columns.valid(b) && !(owned >> b & 1) && !(columns.flags[b] & SINGULAR)) return true;
    }
    return false;
}

// Adds the complex ends of all paths to the account.
PART void account_for_ends(const EliminationArm& arm, const Goal<double>& goal, SearchState& search, const PathEnds& ends) {
    for (int from = 0; from < ends.many; from += BLOCK) {
        CBlock z[6];
        unsigned lanes = 0;
        for (int l = 0; l < BLOCK; ++l) {
            const int i = from + l < ends.many ? from + l : from;
            for (int k = 0; k < 6; ++k) z[k].re.set(l, ends.q[i].z[k][0]), z[k].im.set(l, ends.q[i].z[k][1]);
            lanes |= unsigned(from + l < ends.many && imaginary_part(arm.written, ends.q[i]) > 0.0) << l;
        }
        if (lanes) account_for(arm, goal, search, z, lanes);
    }
}

// Adds the real ends of all paths to the goal, regular ones first: the members of a continuum may fill the other
// columns.
PART Arrived gather_ends(const EliminationArm& arm, const Goal<double>& goal, SearchState& search, int attempt) {
    PathEnds ends;
    const int regular = continue_from_nearest(arm.written, arm.paths, goal, attempt, ends);
    int settled = 0, distant = 0, real = 0;
    unsigned owned = 0;
    bool shared = false;
    for (int pass = 0; pass < 2; ++pass) {
        for (int from = 0; from < ends.many; from += BLOCK) {
            Candidates starts = {{}, 0};
            unsigned needed = 0;
            for (int l = 0; l < BLOCK; ++l) {
                const int i = from + l;
                for (int j = 0; j < 6; ++j) {
                    const double (&z)[2] = ends.q[i < ends.many ? i : from].z[j];
                    starts.q[j].set(l, arm.written.slides[j] ? arm.written.size * z[0] : wrap(atan2(z[1], z[0])));
                }
                if (i >= ends.many) continue;
                const PathEnd end = path_end(arm.written, ends, i);
                starts.lanes |= unsigned(pass == 0 ? end.smooth : end.rough || end.distant) << l;
                real += pass == 0 && end.smooth;
                if (pass == 0) continue;
                distant += end.distant, settled += end.accounts;
                needed |= unsigned(end.rough && !end.accounts) << l;
            }
            if (!starts.lanes) continue;
            int column[BLOCK];
            if (pass == 0) columns_from<false>(arm, goal, search, starts, 12, column);
            else columns_from<true>(arm, goal, search, starts, 60, column);
            for (int l = 0; l < BLOCK; ++l) {
                if (!(starts.lanes >> l & 1) || column[l] < 0) continue;
                settled += needed >> l & 1;
                shared |= (owned >> column[l] & 1) && !(search.columns.flags[column[l]] & SINGULAR);
                owned |= 1u << column[l];
            }
        }
    }
    if (search.provable) account_for_ends(arm, goal, search, ends);
    search.all_known &= distant == 0;
    if (shared || is_stranger(search.columns, owned)) return Arrived::lost;
    // Solutions that are not real come in pairs: an odd number lacks one.
    if (regular == arm.paths.solutions && (regular - real) % 2) return Arrived::lost;
    if (regular + distant == arm.paths.solutions) return Arrived::regular;
    return settled == arm.paths.solutions ? Arrived::settled : Arrived::lost;
}

// ---- starts where nothing else helps, of an arm with slides -------------------------------------------------------------------

// Newton's method from starts all over the joint space.
PART void search_all_over(const EliminationArm& arm, const Goal<double>& goal, SearchState& search) {
    Scatter scatter = Scatter::number(0);
    for (int from = 0; from < ALL_OVER; from += BLOCK) {
        Candidates starts;
        starts.lanes = (1u << BLOCK) - 1;
        for (int l = 0; l < BLOCK; ++l) {
            for (int j = 0; j < 6; ++j) { starts.q[j].set(l, scatter.next() * (arm.written.slides[j] ? arm.written.size : PI)); }
        }
        int column[BLOCK];
        columns_from<true>(arm, goal, search, starts, 30, column);
    }
}

// ---- the whole ---------------------------------------------------------------------------------------------------------------

// Elimination, then continuation if doubts remain. Returns whether it is certain that no solution is missing.
PART bool find_all(const EliminationArm& arm, const Goal<double>& goal, SearchState& search) {
    Eliminant own, other;
    const bool alike = !arm.counter_apart, counting = counts(arm.counter);
    const auto count = [&] {
        return (counting && count_zeros(arm, arm.counter, on_circle(alike ? own : other), search)) ||
               (counts(arm.variant) && !alike && count_zeros(arm, arm.variant, on_circle(own), search)) ||
               (!search.provable && count_precisely(arm, goal, search));
    };
    if (counting && search.account.reals) {
        eliminate(arm, arm.counter, goal, alike ? own : other);
        if (count_zeros(arm, arm.counter, on_circle(alike ? own : other), search)) return true;
    }
    const bool there = counting && search.account.reals;
    if (!(there && alike)) eliminate(arm, arm.variant, goal, own);
    // An arm without known poses is singular everywhere, and its determinant means nothing.
    const bool certain = gather(arm, arm.variant, goal, own, search);
    if (certain && search.provable) return true;
    if (counting && !there && !alike) eliminate(arm, arm.counter, goal, other);
    if (count()) return true;
    if (certain && arm.paths.poses > 0) return true;
    if (search.provable && count_clusters(arm, goal, search) != Status::incomplete) return true;
    bool settled = false;
    for (int attempt = 0; attempt < ATTEMPTS && attempt < arm.paths.poses; ++attempt) {
        const Arrived all = gather_ends(arm, goal, search, attempt);
        if (count()) return true;
        // A curve's own solutions fill the columns, and no count ends a proof.
        search.on_curve = search.certifies && holds_curve(arm, goal, search);
        if (search.on_curve) return false;
        // A result with singular ends needs a second attempt that agrees.
        if (search.provable && count_clusters(arm, goal, search) != Status::incomplete) return true;
        // One that is not proven is tried once more with twice the digits.
        const bool ends = all == Arrived::regular || (all == Arrived::settled && settled);
        if (ends && (search.precisely || !search.provable)) return true;
        search.precisely |= search.provable;
        settled |= all == Arrived::settled;
    }
    return false;
}

// Certifies the solutions that are there.
PART void certify_columns(SearchState& search) {
    if (!search.certifies) return;
    int from[BLOCK], filled = 0;
    Block q[6], least;
    const auto certify = [&] {
        if (!filled) return;
        for (int l = filled; l < BLOCK; ++l) from[l] = from[0];
        for (int l = 0; l < BLOCK; ++l) {
            for (int j = 0; j < 6; ++j) q[j].set(l, search.columns.row(from[l])[j]);
            least.set(l, search.columns.flags[from[l]] & SINGULAR ? 0.0 : 1.0);
        }
        account_for(search, q, (1u << filled) - 1, least);
        filled = 0;
    };
    for (int b = 0; b < search.columns.many; ++b) {
        if (search.columns.valid(b)) from[filled++] = b;
        if (filled == BLOCK) certify();
    }
    certify();
}

// Keeps the solutions whose number is that of a determinant's zeros.
PART Status keep_counted(const EliminationArm& arm, const Goal<double>& goal, const SearchState& search, Account& account) {
    account = search.account;
    if (search.by_zeros) {
        account.pairs = 0, account.expected = {account.counted(), Why::zeros};
        keep_accounted(arm, goal, search);
        return Status::clustered;
    }
    keep_certified(arm, goal, search);
    if (!account.all()) account.expected = {search.zeros, Why::zeros}, account.pairs = account.clusters = 0;
    return Status::complete;
}

// The same with the account; see complete.hpp.
PART Status complete(const EliminationArm& arm, const Goal<double>& goal, const Columns<6>& columns, Account& account) {
    // The rounding of a slide far out moves the tip, so the accepted error grows with the distance of the goal, up to
    // the tolerance.
    const double far = arm.any_slide ? 1.0 + sqrt(dot(goal.p, goal.p)) / arm.written.size : 1.0;
    SearchState search = search_state(arm, goal, columns, min(CONVERGED * far, arm.written.tolerances.reach));
    certify_columns(search);
    const bool certain = find_all(arm, goal, search);
    if (search.counted() || search.by_zeros) return keep_counted(arm, goal, search, account);
    account = search.account;
    if (search.on_curve) {
        mark_singular(arm.written, goal, columns);
        return Status::continuum;
    }
    const Status proven = search.provable ? count_clusters(arm, goal, search) : Status::incomplete;
    account = search.account;
    if (proven != Status::incomplete) {
        keep_accounted(arm, goal, search);
        return proven;
    }
    if (search.provable && count_precisely(arm, goal, search)) return keep_counted(arm, goal, search, account);
    // If no candidate converged, the best may be a double root.
    if (columns.count() == 0 && search.error < NEARLY) {
        if (polish_one<true>(arm.written, goal, search.best, ACROSS_A_VALLEY).error <= arm.written.tolerances.reach) {
            keep(columns, 0, search.best, OTHER);
        }
    }
    // The referee, which lists all solutions, does not know slides.
    if (arm.any_slide && !(certain && search.all_known)) {
        search_all_over(arm, goal, search);
        search_beside_folds(arm.written, goal, columns);
    }
    if (search.certifies && holds_curve(arm, goal, search)) return Status::continuum;
    return Status::incomplete;
}

Status complete(const EliminationArm& arm, const Goal<double>& goal, const Columns<6>& columns) {
    Account account;
    return complete(arm, goal, columns, account);
}

bool are_all(const EliminationArm& arm, const Goal<double>& goal, const Columns<6>& columns) {
    if (!counts(arm.counter)) return false;
    SearchState search = search_state(arm, goal, columns, CONVERGED);
    certify_columns(search);
    if (!search.account.reals) return false;
    Eliminant of;
    eliminate(arm, arm.counter, goal, of);
    if (!count_zeros(arm, arm.counter, on_circle(of), search) && !count_precisely(arm, goal, search)) return false;
    if (search.by_zeros) return false;
    keep_certified(arm, goal, search);
    return true;
}

struct General6 {
    using Arm = EliminationArm;
    static constexpr int branches = 16;
    static STEP void solve(const Arm& arm, const Goal<double>& goal, const Reference<6>&, const Columns<6>& columns) {
        Status status = complete(arm, goal, columns);
        if (status == Status::incomplete) status = refer(arm.written, goal, columns);
        sort(columns);
        set_status(columns.flags[0], status);
    }
};

// See EliminationSolvers.
PART bool prove(const EliminationArm& arm, const double* T, Proof& out) {
    double from[16], proper[16], q[6 * 16];
    std::uint8_t flags[16];
    for (int k = 0; k < 16; ++k) from[k] = T[k];
    if (!(pose_defect<double>(from) <= arm.written.tolerances.rotation)) return false;
    project_rotation(from, proper);
    const Columns<6> columns = {q, flags, 16};
    columns.clear();
    Account account;
    out = {};
    out.status = complete(arm, goal_of(proper), columns, account);
    as_data(account, out);
    if (!is_provable(arm) && out.expected.why == Why::theorem) out.expected.why = Why::unproven;
    return true;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
