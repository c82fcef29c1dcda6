// All solutions of six joints without a special structure. Joints turn or slide.
//
// First the elimination to one joint's angle (hidden_joint.hpp): Newton's method on the arm as written starts from each
// root, real or not. This is fast, and complete if the roots are well separated. At poses with round numbers they often are not:
// several solutions share the hidden angle. So another joint is hidden, and the roots of a pose beside the target, which are
// separated, are starts, too. The certified solutions of all these count together. The referee decides
// what this leaves open.
#pragma once

#include "families/general/complete.hpp"
#include "families/general/gathering.hpp"
#include "families/general/precise_eliminant.hpp"
#include "numbers/scatter.hpp"
#include "propose/candidates.hpp"
#include "referee/referee.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A pose is as far from the target [rad, share of the size]: roots that fall together part by about its square root.
inline constexpr double BESIDE_TARGET = 1e-2;

// What is tried where the first variant leaves doubts: another one, or the roots of a pose beside the target.
struct Proposal {
    int variant;
    bool beside;
};
inline constexpr Proposal PROPOSALS[] = {{1, false}, {0, true}, {1, true}, {2, false}, {2, true}};

// A pose beside the target, in a generic direction.
PART Goal<double> beside(const Written<6>& arm, const Goal<double>& goal) {
    Scatter generic = Scatter::number(7);
    const auto next = [&](double by) { return Vec<double>{by * generic.next(), by * generic.next(), by * generic.next()}; };
    const Vec<double> h = next(1.0), unit_h = (1.0 / sqrt(dot(h, h))) * h;
    const Turn<double> t = cos_sin(BESIDE_TARGET);
    return {each(goal.R, [&](const Vec<double>& v) { return turned_about(v, unit_h, t); }),
            goal.p + next(BESIDE_TARGET * arm.size)};
}

// ---- the whole ---------------------------------------------------------------------------------------------------------------

// Elimination, in several ways if doubts remain, until the solutions are proven to be all.
PART void find_all(const EliminationArm& arm, const Goal<double>& goal, SearchState& search) {
    Eliminant own;
    OnCircle<double> zeros;
    const bool counting = counts(arm.counter);
    bool known = false;
    const auto count = [&] {
        if (!counting) return false;
        if (!known) eliminate(arm, arm.counter, goal, own), zeros = on_circle(own), known = true;
        return count_zeros(arm, arm.counter, zeros, search);
    };
    const auto count_twice = [&] { return count() || (!search.provable && count_precisely(arm, goal, search)); };
    if (search.account.reals && count()) return;
    eliminate(arm, arm.variant[0], goal, own);
    const bool certain = gather(arm, arm.variant[0], goal, own, search);
    if ((certain && search.provable) || count_twice() || certain) return;
    // The referee does without these proposals where nothing is counted, or a singular solution has no certificate.
    if (search.provable ? search.lacks_certificate() : !counting && !arm.any_slide) return;
    const Goal<double> moved = beside(arm.written, goal);
    for (const Proposal& each : PROPOSALS) {
        if (each.variant >= arm.variants) continue;
        const EliminationVariant& variant = arm.variant[each.variant];
        eliminate(arm, variant, each.beside ? moved : goal, own);
        if (gather(arm, variant, goal, own, search, each.beside) || count_twice()) return;
    }
}

// Certifies the solutions that are there.
PART void certify_columns(SearchState& search) {
    if (!search.certifies) return;
    const Columns<6>& columns = search.columns;
    for (int from = 0; from < columns.many; from += BLOCK) {
        Block q[6], least = 1.0;
        const unsigned lanes = solutions_in(columns, from, q);
        for (int l = 0; l < BLOCK; ++l) {
            if (lanes >> l & 1 && columns.flags[from + l] & SINGULAR) least.set(l, 0.0);
        }
        if (lanes) account_for(search, q, lanes, least);
    }
}

// The same with the account; see complete.hpp.
PART Status complete(const EliminationArm& arm, const Goal<double>& goal, const Columns<6>& columns, Account& account) {
    // The rounding of a slide far out moves the tip, so the accepted error grows with the distance of the goal, up to
    // the tolerance.
    const double far = arm.any_slide ? 1.0 + sqrt(dot(goal.p, goal.p)) / arm.written.size : 1.0;
    SearchState search = search_state(arm, goal, columns, min(CONVERGED * far, arm.written.tolerances.reach));
    certify_columns(search);
    find_all(arm, goal, search);
    account = search.account;
    if (search.counted() || account.all()) {
        keep_certified(arm, goal, search);
        if (!account.all()) account.expected = {search.zeros, Why::zeros}, account.pairs = 0;
        return Status::complete;
    }
    // The referee, which lists all solutions, does not know slides. Where none converged, the best may be a double root.
    if (arm.any_slide) {
        const double enough = columns.count() ? search.enough : arm.written.tolerances.reach;
        search_all_over(arm.written, goal, Origin::doubtful, enough, columns);
    }
    return Status::incomplete;
}

Status complete(const EliminationArm& arm, const Goal<double>& goal, const Columns<6>& columns) {
    Account account;
    return complete(arm, goal, columns, account);
}

bool prove_by_count(const EliminationArm& arm, const Goal<double>& goal, const Columns<6>& columns) {
    if (!counts(arm.counter)) return false;
    SearchState search = search_state(arm, goal, columns, CONVERGED);
    certify_columns(search);
    if (!search.account.reals || search.lacks_certificate()) return false;
    Eliminant of;
    eliminate(arm, arm.counter, goal, of);
    if (!count_zeros(arm, arm.counter, on_circle(of), search) && !count_precisely(arm, goal, search)) return false;
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
