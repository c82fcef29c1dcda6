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
// the branches are certified one by one, and the zeros of a determinant counted (eliminant.hpp). Elimination looks for what lacks.
//
// A solution is a branch's own if Newton's method, started at the branch, moved by less than half of the Jacobian's smallest
// singular value: the Jacobian's Lipschitz constant is about 1 (per rad, lengths as shares of the size), so by Kantorovich's
// theorem there is one solution about the start, and no second one. Others belong to no branch.
#pragma once

#include "answers/on_curve.hpp"
#include "answers/referee.hpp"
#include "families/general/complete.hpp"
#include "families/imperfect/certified.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Up to this imperfection the elimination alone finds too few solutions, since its equations agree with those of the ideal arm to
// many digits. The closed form's careful path, one branch at a time, then finds the others.
inline constexpr double CLOSE_BY = 1e-4;
// Up to this imperfection boxes are tried.
inline constexpr double BOXED = 1e-3;
// Boxes are not divided where the arms differ by less than FINEST, which is little more than the rounding of a loop: nothing tells
// the members of what the ideal arm leaves free apart. Below KEEPS_CURVES these members keep the pose to about the tolerance of
// solutions, so curves are looked for first.
inline constexpr double FINEST = 1e-13, KEEPS_CURVES = 1e-9;
// A joint that the ideal arm leaves free has a few values on the arm as written. From this imperfection on they are far enough
// apart for elimination and continuation to find them without all_around(). Chosen by tests: at 1e-3 a solution was lost.
inline constexpr double FAR_OFF = 4e-3;

// Collects candidates until a block is full; Newton's method then runs on all of them side by side.
struct Waiting {
    const Written<6>& written;
    const Goal<double>& goal;
    const Columns<6>& columns;
    Block q[6];
    int marks[BLOCK], filled = 0;

    STEP void add(const double* candidate, int kinds) {
        for (int j = 0; j < 6; ++j) q[j].set(filled, candidate[j]);
        marks[filled] = kinds;
        if (++filled == BLOCK) follow();
    }
    PART void follow() {
        const int many = filled;
        if (!many) return;
        for (; filled < BLOCK; ++filled) {
            for (int j = 0; j < 6; ++j) q[j].set(filled, q[j][0]);
        }
        filled = 0;
        // Most of them may lead to no solution.
        const auto end = polish_block<true>(written, spread<Block>(goal), q, {60, FINISHED, PATIENCE});
        for (int l = 0; l < many; ++l) {
            double at[6];
            for (int j = 0; j < 6; ++j) at[j] = q[j][l];
            if (!(end.error[l] <= CONVERGED) || !is_new(written, goal, columns, at)) continue;
            urdf_ik::URDF_IK_LEVEL::add(written, goal, columns, 0, at,
                                        end.least[l] < NEAR_FOLD ? singular_marks(written, goal, at, marks[l]) : 0);
        }
    }
};

template <class Family> struct Imperfect {
    using Arm = ImperfectArm<typename Family::Arm>;
    static constexpr int branches = 16;
    // Signs do not tell the branches of such a family apart: all poses go to its careful path and to the elimination.
    static constexpr bool by_quartic = !Family::by_signs;

    static PART void answer(const void* arm, const Seen<Block>& seen, int first, Answers& to) {
        const auto& of = *static_cast<const typename Family::Arm*>(arm);
        const Branch<Block> at = branches_from<Family>(of, seen, first, of.ideal.signs);
        for (int j = 0; j < 6; ++j) store(at.turn[j].c, to.c[j] + first), store(at.turn[j].s, to.s[j] + first);
        store(at.arms, to.arms + first);
    }

    static PART void include_branches(const void* arm, const Seen<Block>& target, const Block& turn, const Block& shift, int first,
                                      Boxes& to) {
        const auto& of = *static_cast<const typename Family::Arm*>(arm);
        include<Family>(of, target, turn, shift, first, of.ideal.signs, to);
    }

    static PART void include_boxes(const void* arm, const Targets& targets, const Signs<Block>& signs, const Arcs<Block>& known,
                                   BoxBlock& to) {
        include_within<Family>(*static_cast<const typename Family::Arm*>(arm), targets.middle, targets.moving, targets.turn,
                               targets.shift, signs, known, to);
    }

    static void beyond_ends(const Arm& arm, const Batch& batch) { branches_beyond<Family>(arm.family, batch, branches); }

    static STEP void solve(const Arm& arm, const Goal<double>& goal, const Reference<6>& reference, const Columns<6>& columns) {
        const Seen<double> seen = to_frame_1(goal, arm.family.ideal);
        unsigned open = 255;
        bool loose = by_quartic;
        const double off = arm.family.ideal.imperfection;
        const bool close = off < CLOSE_BY;
        if constexpr (!by_quartic) {
            Known known;
            Certified all;
            if (off < BOXED) {
                const Inclusion family = {
                    &arm.family, include_branches, include_boxes, {0, Family::before_elbow, Family::after_elbow}};
                const auto certified = [&](bool divides) {
                    known = {};
                    return certify_all(arm.family.written, arm.both, arm.family.ideal, goal, seen, family, divides, known);
                };
                all = certified(off >= KEEPS_CURVES);
                // A curve of solutions has no boxes that end, and decides the status.
                if (all.status == Status::incomplete && off > FINEST && off < KEEPS_CURVES) {
                    Family::closely(arm.family, goal, seen, reference, columns, 255);
                    if (keep_curve(arm.family.written, goal, columns)) {
                        set_status(columns.flags[0], Status::continuum);
                        return;
                    }
                    columns.clear();
                    all = certified(true);
                }
            }
            if (all.status != Status::incomplete) {
                for (int i = 0; i < all.many; ++i) {
                    const auto& each = all.root[i];
                    keep(columns, each.branch, each.q, each.singular ? singular_marks(arm.family.written, goal, each.q, 0) : 0);
                }
                set_status(columns.flags[0], all.status);
                return;
            }
            known = follow_branches(arm.both, seen, {&arm.family, answer}, known);
            open = known.open;
            loose = !(known.least_arm > arm.loose.written.tolerances.continuum);
            const Written<6>& written = arm.family.written;
            // The branches' own solutions first: they take the branch's column.
            for (int k = 0; k < 16; ++k) {
                const int b = k % 8;
                const bool own = k < 8;
                if (!((own ? known.found : known.reached & ~known.found) >> b & 1)) continue;
                double q[6];
                for (int j = 0; j < 6; ++j) q[j] = wrap(known.angle[j][b] - arm.family.ideal.offset[j]);
                if (own) keep(columns, b, q, 0);
                else if (is_new(written, goal, columns, q)) keep(columns, b, q, singular_marks(written, goal, q, 0));
            }
            if (!open && !arm.both.boxes) {
                if (!are_all(arm.elimination, goal, columns)) set_status(columns.flags[0], refer(written, goal, columns));
                return;
            }
            if ((close || loose) && are_all(arm.elimination, goal, columns)) return;
        }
        if (by_quartic || close) Family::closely(arm.family, goal, seen, reference, columns, open);
        if (loose && !by_quartic && off < FAR_OFF) all_around(arm, goal, seen, columns);
        Status status = complete(arm.elimination, goal, columns);
        if (status == Status::incomplete) {
            if (by_quartic) all_around(arm, goal, seen, columns);
            if (keep_curve(arm.family.written, goal, columns)) status = Status::continuum;
        }
        if (status == Status::incomplete) status = refer(arm.family.written, goal, columns);
        set_status(columns.flags[0], status);
    }

    // A joint that the ideal arm leaves free has a few values on the arm as written: the ideal arm is solved with its nearly free
    // joints at values around the circle. A joint that is free on a part of the circle only is put at the nearer end of this part.
    // A branch whose solution is the same for three values that do not all lie on one half of the circle does not depend on them
    // and is not solved again.
    static PART void all_around(const Arm& arm, const Goal<double>& goal, const Seen<double>& seen, const Columns<6>& columns) {
        Waiting waiting = {arm.family.written, goal, columns, {}, {}};
        double first[6 * 8], room[6 * 8];
        std::uint8_t flags[8];
        const Columns<6> there = {room, flags, 8};
        unsigned fixed = 255;
        for (int k = 0; k < AROUND; ++k) {
            Reference<6> at = reference_of<6>(nullptr);
            for (double& each : at.q) each = PI * (2.0 * (5 * k % AROUND) / AROUND - 1.0);
            there.clear();
            Family::closely(arm.loose, goal, seen, at, there, k < 3 ? 255u : ~fixed & 255u);
            for (int b = 0; b < 8; ++b) {
                bool same = k > 0;
                for (int j = 0; j < 6; ++j) same = same && there.row(b)[j] == first[6 * b + j];
                if (k > 0 && !same) fixed &= ~(1u << b);
                if (k == 0) __builtin_memcpy(first + 6 * b, there.row(b), sizeof(double) * 6);
                if (there.valid(b) && !same) waiting.add(there.row(b), flags[b] & ~VALID);
            }
        }
        waiting.follow();
    }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
