// Arms near a family: the ideal arm's closed form, corrected for the arm as written, proposes; boxes or a count of zeros prove.
//
// If the arm as written, W, reaches the target T at q, then the ideal arm I at q reaches I(q) W(q)^-1 T. This pose is near T and
// changes slowly with q. The solutions of W are therefore the fixed points of an iteration: solve a branch of the ideal arm for
// q, correct the target by the difference between the two arms at q, and solve the same branch again. One round comes within
// about the square of the imperfection. Beyond a branch's end the closed form takes roots of |margin| (see margin_root), so that
// solutions of W next to the end have a start too. Newton's method on W does the rest.
//
// Up to an imperfection of BOXED the result is proven first, by boxes that hold all real solutions for every displacement
// I(q) W(q)^-1: see certified.hpp. Where a box stays open, and on arms farther off, the solutions that Newton's method reaches from
// the branches are certified one by one, and the zeros of a determinant counted (eliminant.hpp). From an imperfection of CLOSE_BY
// on, elimination searches for solutions that lack. What is still open, the referee decides.
//
// A solution is kept in its branch's column if Newton's method, started at the branch, moved by less than half of the Jacobian's
// smallest singular value: it is then hardly another branch's. This chooses columns and proves nothing.
#pragma once

#include "families/general/complete.hpp"
#include "families/imperfect/certified.hpp"
#include "referee/on_curve.hpp"
#include "referee/referee.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Below this imperfection elimination finds too few solutions, since its equations agree with those of the ideal arm to many
// digits: the zeros are counted, and the referee decides the rest.
inline constexpr double CLOSE_BY = 1e-4;
// Up to this imperfection boxes are tried.
inline constexpr double BOXED = 1e-3;
// Below this imperfection the members of a curve of the ideal arm's solutions keep the pose to about the tolerance of solutions:
// the closed form proposes those near the reference.
inline constexpr double KEEPS_CURVES = 1e-9;

template <class Family> struct Imperfect {
    using Arm = ImperfectArm<typename Family::Arm>;
    static constexpr int branches = 16;
    // Where signs do not tell the family's branches apart, every pose starts from the roots of its quartic.
    static constexpr bool by_quartic = !Family::by_signs;

    static PART void answer(const void* arm, const Seen<Block>& seen, int first, Answers& to) {
        const auto& of = *static_cast<const typename Family::Arm*>(arm);
        const Branch<Block> at = branches_from<Family>(of, seen, first, of.ideal.signs);
        for (int j = 0; j < 6; ++j) store(at.turn[j].c, to.c[j] + first), store(at.turn[j].s, to.s[j] + first);
    }

    static PART void include_branches(const void* arm, const Seen<Block>& target, const Block& turn, const Block& shift, int first,
                                      Boxes& to) {
        const auto& of = *static_cast<const typename Family::Arm*>(arm);
        include<Family>(of, target, turn, shift, first, of.ideal.signs, to);
    }

    static void beyond_ends(const Arm& arm, const Batch& batch) { branches_beyond<Family>(arm.family, batch, branches); }

    // Whether boxes prove the branches' solutions, which are kept. known: what is left open.
    static PART bool is_proven(const Arm& arm, const Goal<double>& goal, const Seen<double>& seen, Known& known,
                               const Columns<6>& columns) {
        const auto& [family, written, elimination, both] = arm;
        certify_all(family.written, both, family.ideal, goal, seen, {&family, include_branches}, known);
        if (known.open) return false;
        keep_reached(arm, goal, known, columns);
        set_status(columns.flags[0], Status::complete);
        return true;
    }

    // Keeps what Newton's method reaches from the branches. Their own solutions come first: they take the branch's column.
    static PART void keep_reached(const Arm& arm, const Goal<double>& goal, const Known& known, const Columns<6>& columns) {
        const Written<6>& written = arm.family.written;
        for (int k = 0; k < 16; ++k) {
            const int b = k % 8;
            const bool own = k < 8;
            if (!((own ? known.found : known.reached & ~known.found) >> b & 1)) continue;
            double q[6];
            for (int j = 0; j < 6; ++j) q[j] = wrap(known.angle[j][b] - arm.family.ideal.offset[j]);
            if (own) {
                keep(columns, b, q, 0);
                continue;
            }
            if (missed_by(written, goal, q) > CONVERGED)
                polish_one<true>(written, goal, q, {ROUNDS_FROM_BRANCH, FINISHED, PATIENCE});
            if (is_new(written, goal, columns, q)) keep(columns, b, q, singular_marks(written, goal, q, 0));
        }
    }

    static STEP void solve(const Arm& arm, const Goal<double>& goal, const Reference<6>& reference, const Columns<6>& columns) {
        const Written<6>& written = arm.family.written;
        const Seen<double> seen = to_frame_1(goal, arm.family.ideal);
        const double off = arm.family.ideal.imperfection;
        Known known;
        if constexpr (!by_quartic) {
            if (off < BOXED && is_proven(arm, goal, seen, known, columns)) return;
        }
        if (by_quartic || off < KEEPS_CURVES) {
            Quartic roots = {};
            if constexpr (by_quartic) roots = Family::quartic(arm.family, seen);
            propose<Family>(arm.family, goal, seen, roots, reference, double_roots, 255u, columns);
        } else if constexpr (!by_quartic) {
            keep_reached(arm, goal, follow_branches(arm.both, seen, {&arm.family, answer}, known), columns);
        }
        Status status = Status::complete;
        if (off >= CLOSE_BY) status = complete(arm.elimination, goal, columns);
        else if (!prove_by_count(arm.elimination, goal, columns)) status = Status::incomplete;
        if (status == Status::incomplete) status = refer(written, goal, columns);
        set_status(columns.flags[0], status);
    }
};

template <class Kind> constexpr SolveArm<typename Kind::Arm> solver_of() {
    if constexpr (Kind::by_signs) return solve_closed_form<Kind>;
    else return solve_singly<Kind>;
}
// The solvers of a family's kinds.
template <class First, class... Rest>
inline constexpr FamilySolvers<typename First::Arm, 1 + int(sizeof...(Rest))> solvers_of = {
    {solver_of<First>(), solver_of<Rest>()...}, {solve_singly<Imperfect<First>>, solve_singly<Imperfect<Rest>>...}};

}  // namespace urdf_ik::URDF_IK_LEVEL
