// Candidates where a closed form's fast path is in doubt: Newton's method starts from each branch.
#pragma once

#include "numbers/quartic.hpp"
#include "propose/answer.hpp"
#include "propose/branch.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Newton's method from a branch ends after so many rounds. Past a branch's end, and behind a short lever arm, it takes most.
inline constexpr int ROUNDS_FROM_BRANCH = 40;

// Steps along a curve to the member nearest to a reference; a joint moves along it where the unit direction's part is larger.
inline constexpr int ROUNDS_TO_REFERENCE = 4;
inline constexpr double MOVING = 0.1;

// Whether three signs tell a family's branches apart; whether they follow from the roots of a quartic. Bit root_bit of a branch's
// number tells root 0 from root 1, and 2 from 3; the next higher one of the two bits that tell roots tells these pairs. root_joint:
// the joint whose angles the roots are.
template <class Family> constexpr bool branches_have_signs() {
    return requires { requires Family::by_signs; };
}
template <class Family> constexpr bool has_quartic() {
    return requires { &Family::quartic; } && !branches_have_signs<Family>();
}
template <class Family> STEP int root_of_branch(int b) { return Family::root_bit == 2 ? b >> 1 : (b >> 2) << 1 | (b & 1); }

// Attempts to start Newton's method, with free joints at the reference: with double roots where margins are zero to rounding, and
// with both roots.
enum Attempt { double_roots, both_roots };

// The values of free joints, offsets included.
STEP FreeJoints free_values(const IdealFrames& ideal, const Tolerances& tolerances, const Reference<6>& reference) {
    FreeJoints out;
    Row<8> angles = 0.0;
    for (int j = 0; j < 6; ++j) angles.set(j, reference.q[j] + ideal.offset[j]);
    const Turn<Row<8>> points = cos_sin_of_any(angles);
    for (int j = 0; j < 6; ++j) out.turn[j] = {points.c[j], points.s[j]};
    out.below = tolerances.continuum;
    return out;
}

// The flags of the singularities that a branch is near, before the Jacobian decides.
template <class Family> STEP int marks_of(const Branch<Block>& at, int lane, double fold) {
    int out = 0;
    const Block* margins[3] = {&at.shoulder, &at.elbow, &at.wrist};
    for (int k = 0; k < 3; ++k) out |= min(*margins[k], at.lever[k])[lane] <= fold ? Family::flags[k] : 0;
    return out;
}

// The lanes in which a margin is zero to rounding, so that two solutions are one double root. The margin is a difference of
// squares: if the squared lever arm is small, so is the rounding error, and the solutions differ by half a turn instead of meeting.
STEP MaskOf<Block> are_double(const Block& margin, const Block& lever) { return margin <= ROUNDING * root(max(lever, 0.0)); }

// Moves q, at which a joint is free, along its curve to the member nearest to the reference that the caller gave; else so that the
// joint nearest to zero is there. Returns the Jacobian's smallest singular value at its end.
PART double approach_reference(const Written<6>& arm, const Goal<double>& goal, const Reference<6>& reference, double (&q)[6]) {
    const bool given = reference.given > 0.0;
    for (int round = 0;; ++round) {
        const Weakest<6> weak = weakest_at(arm, goal, q);
        if (weak.value > arm.tolerances.singular || round == ROUNDS_TO_REFERENCE) return weak.value;
        double apart[6], along = 0.0, nearest = __builtin_inf();
        for (int j = 0; j < 6; ++j) {
            apart[j] = wrap(reference.q[j] - q[j]);
            if (given) along += weak.direction[j] * apart[j];
            else if (abs(weak.direction[j]) > MOVING && abs(apart[j]) < min(nearest, SAME)) {
                nearest = abs(apart[j]), along = apart[j] / weak.direction[j];
            }
        }
        if (abs(along) <= FINISHED) return weak.value;
        double at[6];
        for (int j = 0; j < 6; ++j) at[j] = q[j];
        if (!(move_along(arm, goal, ACROSS_A_VALLEY, along, weak.direction, at) <= FINISHED)) return weak.value;
        double before = 0.0, after = 0.0;
        for (int j = 0; j < 6; ++j)
            before += apart[j] * apart[j], after += wrap(reference.q[j] - at[j]) * wrap(reference.q[j] - at[j]);
        if (given && !(after < before)) return weak.value;
        for (int j = 0; j < 6; ++j) q[j] = at[j];
    }
}

// The branches at which no joint is free, and those that started at a double root.
struct Proposed {
    unsigned fixed, merged;
};

// Adds what Newton's method reaches from the branches in `wanted`. roots: of families with a quartic; where it may vanish, its
// angle is free too in the second attempt.
template <class Family>
PART Proposed propose(const typename Family::Arm& arm, const Goal<double>& goal, const Seen<double>& seen, const Quartic& roots,
                      const Reference<6>& reference, Attempt attempt, unsigned wanted, const Columns<6>& columns) {
    const IdealFrames& ideal = arm.ideal;
    const Written<6>& written = arm.written;
    const FreeJoints free = free_values(ideal, written.tolerances, reference);
    const Goal<Block> goals = spread<Block>(goal), target = spread<Block>(seen);
    Proposed out = {};
    for (int first = 0; first < 8; first += BLOCK) {
        const auto sign = [&](int i) { return load<Block>(ideal.signs[i] + first); };
        Signs<Block> signs = {sign(0), sign(1), sign(2), {}, &free};
        Block moves = 0.0, q[6];
        for (int l = 0; l < BLOCK; ++l) {
            if constexpr (has_quartic<Family>()) {
                const int root = root_of_branch<Family>(first + l);
                const bool here = root < roots.count && (roots.whole || attempt == double_roots);
                const Turn<double>& turn = here ? roots.root[root] : free.turn[Family::root_joint];
                signs.root.c.set(l, turn.c), signs.root.s.set(l, turn.s);
                if (!here && (roots.whole || attempt == double_roots)) continue;
            }
            moves.set(l, wanted >> (first + l) & 1u);
        }
        const auto moving = moves > Block(0.0);
        if (!any(moving)) continue;
        Branch<Block> at;
        // A step's margin is known once the roots of the steps before it are.
        unsigned merged = 0;
        for (int round = 0; round <= 3; ++round) {
            branch_of_lanes<Family>(arm, target, signs, at);
            const auto shoulder = are_double(at.shoulder, at.lever[0]), elbow = are_double(at.elbow, at.lever[1]),
                       wrist = are_double(at.wrist, at.lever[2]);
            const unsigned now = bits(shoulder) | bits(elbow) << 8 | bits(wrist) << 16;
            if (attempt == both_roots || now == merged) break;
            merged = now;
            signs.shoulder = select(shoulder, 0.0, sign(0)), signs.elbow = select(elbow, 0.0, sign(1));
            signs.wrist = select(wrist, 0.0, sign(2));
        }
        out.merged |= (merged | merged >> 8 | merged >> 16) << first;
        out.fixed |= bits(at.arms > Block(free.below)) << first;
        for (int j = 0; j < 6; ++j) q[j] = wrap(angle(at.turn[j]) - ideal.offset[j]);
        const Polished<Block> end = polish_block<true>(written, goals, q, {ROUNDS_FROM_BRANCH, FINISHED, PATIENCE}, moving);
        const unsigned reached = bits(moving & (end.error <= Block(written.exact ? written.tolerances.reach : CONVERGED)));
        for (int l = 0; l < BLOCK; ++l) {
            double x[6];
            for (int j = 0; j < 6; ++j) x[j] = q[j][l];
            if (!(reached >> l & 1)) continue;
            // `least` is a lower bound of the Jacobian's smallest singular value.
            double least = end.least[l];
            const bool moves_freely = !(out.fixed >> (first + l) & 1);
            if (moves_freely) least = approach_reference(written, goal, reference, x);
            if (!is_new(written, goal, columns, x)) continue;
            if (!moves_freely && least < NEAR_FOLD) least = weakest_at(written, goal, x).value;
            const Tolerances& tolerances = written.tolerances;
            keep(columns, first + l, x, singular_marks(tolerances, least, marks_of<Family>(at, l, tolerances.fold)));
        }
    }
    return out;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
