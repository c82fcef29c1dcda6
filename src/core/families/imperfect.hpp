// Arms near a family: the ideal arm's closed form, corrected for the arm as written, and the elimination where that does
// not decide.
//
// Where the arm as written, W, is in the target T at q, the ideal arm is at q in I(q) W(q)^-1 T: near T, and changing slowly
// with q. So the solutions of W are the fixed points of: take a branch's answer q, correct the target by what the two arms
// differ at q, answer again with the same branch. A few rounds come close; Newton's method on W then ends it.
//
// What decides a branch b:
// - A solution: Newton's method, started with all margins above zero, moved by less than half of the Jacobian's smallest
//   singular value and converged. The Jacobian's Lipschitz constant is about 1 (per rad, lengths as shares of the size), so
//   by Kantorovich's theorem there is one solution about the start, and no second one.
// - None: a margin m is below zero. Let x be the signed root that tells the branch from its twin, the branch with the
//   other sign of that root: solutions have x^2 = m(x), where m depends on x only through the correction, m(x) = m0 + c x
//   to first order. Beyond the end the closed form takes x = +-sqrt(-m) (see margin_root), so the rounds end at x1 > 0 and
//   -x2 < 0 with x1^2 = -m0 - c x1, x2^2 = -m0 + c x2: x1 and -x2 are the roots of x^2 + c x + m0 = 0, hence c = x2 - x1
//   and -m0 = x1 x2. x^2 = m0 + c x has no real root where c^2 < -4 m0, (x2 - x1)^2 < 4 x1 x2: where the margins of the
//   twins, -x1^2 and -x2^2, are less than a factor of 34 apart. AGREE asks for less.
// Solutions are counted by that: with complex ones, every pair of twins has two. A pose is decided if each of its branches is.
#pragma once

#include "../blocks.hpp"
#include "elimination.hpp"
#include "imperfect_arm.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Twins whose negative margins are less than this factor apart are both beyond their end (34 would do if m were linear in x);
// the same of a margin before and after a correction.
inline constexpr double AGREE = 2.0;
// The rounds have come to rest where the last move is less than half of x: the square of it, over the margin.
inline constexpr double REST = 0.25;
// An angle is fixed where its squared arm is above the square of this times the drift: the correction then turns it by less
// than a quarter of what it has turned, and converges. Below, the ideal arm all but leaves it free, and the arm as written may
// have more solutions.
inline constexpr double FIXED_BY_DRIFT = 4.0;
// Kantorovich's share of the smallest singular value, see above.
inline constexpr double KANTOROVICH = 0.5;
// Below this a margin is rounding.
inline constexpr double ROUNDED_MARGIN = 1e-12;
// Imperfection up to which the elimination has not come into its element, its equations being those of the ideal arm to many
// digits: there the closed form's careful path, one branch at a time, helps it. And from which the found solutions are so
// well apart that the elimination, missing none of them, is believed at once.
inline constexpr double CLOSE_BY = 1e-4, FAR_OFF = 1e-3;
// How often a target is corrected before the pose is given to the elimination.
inline constexpr int CORRECTIONS = 4;

// All branches of a block of targets, beyond their ends too.
struct AllBranches {
    Block q[8][6];
    Clearance<Block> clear[8];
    STEP void set(int b, const Block (&angles)[6], const MaskOf<Block>&, const MaskOf<Block>&, const Clearance<Block>& at) {
        for (int j = 0; j < 6; ++j) q[b][j] = angles[j];
        clear[b] = at;
    }
    STEP void leave_open() {
        for (int b = 0; b < 8; ++b) {
            for (int j = 0; j < 6; ++j) q[b][j] = __builtin_nan("");
            clear[b] = {0.0, 0.0, 0.0, 0.0};
        }
    }
};

STEP Block block_at(const double* from) {
    Block x;
    constexpr int L = sizeof(x.r[0]) / sizeof(double);
    for (int k = 0; k < BLOCK / L; ++k) x.r[k] = *(const Register<L>::unaligned*)(from + L * k);
    return x;
}
STEP void put_block(const Block& x, double* to) {
    constexpr int L = sizeof(x.r[0]) / sizeof(double);
    for (int k = 0; k < BLOCK / L; ++k) *(Register<L>::unaligned*)(to + L * k) = x.r[k];
}

// by_quartic: the family has no block path; all its poses go to its careful path and the elimination.
template <class Family, bool by_quartic = false> struct Imperfect {
    using Arm = ImperfectArm<typename Family::Arm>;
    static constexpr int branches = 16;

    // The eight branches of one pose, each for a target of its own: joint values, margins of shoulder, elbow and wrist.
    struct Answers {
        double q[6][8], margin[3][8], arms[8];
    };
    // What is known of them, a bit a branch.
    struct Known {
        unsigned open = 255, found = 0;
        double q[6][8];
    };

    static PART void answer(const Arm& arm, const Seen<Block>& seen, int first, Answers& to) {
        AllBranches all;
        Family::fast(arm.family, seen, all);
        for (int l = 0; l < BLOCK; ++l) {
            const int b = first + l;
            for (int j = 0; j < 6; ++j) to.q[j][b] = all.q[b][j][l];
            to.margin[0][b] = all.clear[b].shoulder[l], to.margin[1][b] = all.clear[b].elbow[l];
            to.margin[2][b] = all.clear[b].wrist[l], to.arms[b] = all.clear[b].arms[l];
        }
    }

    // I(q) W(q)^-1 goal.
    static PART Seen<Block> corrected(const Arm& arm, const Goal<Block>& goal, const Block (&q)[6]) {
        const Frame<Block> W = place(arm.inner, q).tip, I = place(arm.ideal, q).tip;
        const auto through = [&](const Vec<Block>& a) { return I.R * Vec<Block>{dot(W.R.x, a), dot(W.R.y, a), dot(W.R.z, a)}; };
        return {{through(goal.R.x), through(goal.R.y), through(goal.R.z)}, I.p + through(goal.p - W.p)};
    }

    // Whether branch b is beyond an end, after a correction that moved it by `last` [rad].
    static STEP bool is_beyond(const Answers& before, const Answers& now, int b, double last, double fixed) {
        const double least = max(fixed * fixed, ROUNDED_MARGIN);
        for (int k = 0; k < 3; ++k) {
            const double m = -now.margin[k][b], twin = -now.margin[k][b ^ (4 >> k)], past = -before.margin[k][b];
            const double others = min(abs(now.margin[(k + 1) % 3][b]), abs(now.margin[(k + 2) % 3][b]));
            if (min(m, others) >= least && min(twin, past) * AGREE > m && max(twin, past) < AGREE * m && last * last < REST * m) return true;
        }
        return false;
    }

    // One more correction of all branches, then what it decides of those that are open.
    static PART void decide(const Arm& arm, const Goal<Block>& goal, Answers& now, Known& known) {
        const Answers before = now;
        double last[8];
        for (int first = 0; first < 8; first += BLOCK) {
            Block q[6], moved = 0.0;
            for (int j = 0; j < 6; ++j) q[j] = block_at(before.q[j] + first);
            answer(arm, corrected(arm, goal, q), first, now);
            for (int j = 0; j < 6; ++j) moved = max(moved, abs(wrap(block_at(now.q[j] + first) - q[j])));
            put_block(moved, last + first);
        }
        const double fixed = FIXED_BY_DRIFT * arm.drift;
        unsigned inside = 0;
        for (int b = 0; b < 8; ++b) {
            if (!(known.open >> b & 1) || !(now.arms[b] >= fixed * fixed)) continue;
            if (is_beyond(before, now, b, last[b], fixed)) known.open &= ~(1u << b);
            else if (min(now.margin[0][b], min(now.margin[1][b], now.margin[2][b])) > 0.0) inside |= 1u << b;
        }
        for (int first = 0; first < 8; first += BLOCK) follow(arm, goal, now, inside, first, known);
    }

    // Newton's method on a group of branches whose bits are in `inside`.
    static PART void follow(const Arm& arm, const Goal<Block>& goal, const Answers& now, unsigned inside, int first, Known& known) {
        constexpr unsigned all = (1u << BLOCK) - 1;
        inside = inside >> first & all;
        if (!inside) return;
        Block q[6], start[6], chosen, moved = 0.0;
        for (int j = 0; j < 6; ++j) q[j] = start[j] = block_at(now.q[j] + first);
        for (int l = 0; l < BLOCK; ++l) chosen.set(l, inside >> l & 1);
        const Polished<Block> end = polish<false>(arm.inner, goal, q, {5, CONVERGED, 2}, chosen > Block(0.5));
        for (int j = 0; j < 6; ++j) moved = max(moved, abs(wrap(q[j] - start[j])));
        const unsigned found = inside & bits((end.error <= Block(CONVERGED)) & (moved <= KANTOROVICH * end.least) &
                                             (end.least >= Block(arm.written.tolerances.singular)));
        known.found |= found << first, known.open &= ~(found << first);
        for (int l = 0; l < BLOCK; ++l) {
            for (int j = 0; j < 6 && found >> l & 1; ++j) known.q[j][first + l] = q[j][l];
        }
    }

    // The branches that are decided, a bit each in `found` and `open` for what is not.
    static PART Known decide_all(const Arm& arm, const Seen<double>& seen) {
        const Goal<Block> target = spread<Block>({seen.R, seen.p});
        Answers now;
        Known known;
        for (int first = 0; first < 8; first += BLOCK) answer(arm, {target.R, target.p}, first, now);
        for (int round = 0; round < CORRECTIONS && known.open; ++round) decide(arm, target, now, known);
        return known;
    }

    static STEP void solve(const Arm& arm, const Goal<double>& goal, const Reference<6>& reference, const Columns<6>& columns) {
        const Seen<double> seen = to_frame_1(goal, arm.family.ideal);
        unsigned open = 255;
        if constexpr (!by_quartic) {
            const Known known = decide_all(arm, seen);
            open = known.open;
            for (int b = 0; b < 8; ++b) {
                double q[6];
                for (int j = 0; j < 6; ++j) q[j] = known.q[j][b];
                if (known.found >> b & 1) keep(columns, b, q, 0);
            }
            if (!open && columns.count() % 2 == 0) return;
        }
        const double off = arm.family.ideal.imperfection;
        if (by_quartic || off < CLOSE_BY) Family::closely(arm.family, goal, seen, reference, columns, open);
        complete(arm.elimination, goal, columns, by_quartic || off < FAR_OFF);
    }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
