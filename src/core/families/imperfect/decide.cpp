// See decide.hpp; the criteria are derived in imperfect.hpp. Compiled once for every instruction set.
#include "families/imperfect/decide.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A branch is beyond its end if its negative margin differs by less than this factor from that of its twin, and from
// its own before the last correction. 34 would do if m were linear in x.
inline constexpr double AGREE = 2.0;
// The rounds have come to rest if the last move is less than half of x: its square is less than this share of the
// margin.
inline constexpr double REST = 0.25;
// An angle is fixed if its lever arm exceeds this times the drift, both as shares of the size. If the joints change by
// x, the correction changes by at most drift x. This turns an angle of lever arm a by drift x / a, less than x / 4. So
// each round leaves a quarter of the one before, CORRECTIONS rounds 1/256 of the first. With a shorter lever arm the
// ideal arm leaves the angle nearly free, and the elimination decides: the rounds converge slowly, and below 1 perhaps
// not at all, and the arm as written may have more solutions.
inline constexpr double FIXED_BY_DRIFT = 4.0;
// A branch is beyond an end only if the roots of its margins exceed this times the drift. Another root x moves the
// joints by drift / x, and changes the margin that tells the twins apart by that share of itself. In tests 16 was too
// little for two of 20,000 joint vectors planted next to two singularities. 64 costs no time, as few poses are so near
// to an end.
inline constexpr double BEYOND_BY_DRIFT = 64.0;
// A margin below this is rounding.
inline constexpr double ROUNDED_MARGIN = 1e-12;
// How often a target is corrected before the pose is given to the elimination.
inline constexpr int CORRECTIONS = 4;

// I(q) W(q)^-1 goal.
PART Seen<Block> corrected(const BothArms& arm, const Goal<Block>& goal, const Turn<Block> (&turn)[6]) {
    const Frame<Block> W = tip_after(arm.written, turn), I = tip_after(arm.ideal, turn);
    const auto through = [&](const Vec<Block>& a) { return I.R * Vec<Block>{dot(W.R.x, a), dot(W.R.y, a), dot(W.R.z, a)}; };
    return {each(goal.R, through), I.p + through(goal.p - W.p)};
}

// Whether branch b is beyond an end, after a correction that moved it by the root of `square` [rad].
STEP bool is_beyond(const Answers& before, const Answers& now, int b, double square, double drift) {
    const double least = max(BEYOND_BY_DRIFT * BEYOND_BY_DRIFT * drift * drift, ROUNDED_MARGIN);
    for (int k = 0; k < 3; ++k) {
        const double m = -now.margin[k][b], twin = -now.margin[k][b ^ (4 >> k)], past = -before.margin[k][b];
        const double others = min(abs(now.margin[(k + 1) % 3][b]), abs(now.margin[(k + 2) % 3][b]));
        if (min(m, others) >= least && min(twin, past) * AGREE > m && max(twin, past) < AGREE * m && square < REST * m) return true;
    }
    return false;
}

// Newton's method on one block of branches, those whose bits are in `inside`. It may move by half of the Jacobian's smallest
// singular value (Kantorovich); see imperfect.hpp.
PART void follow(const BothArms& arm, const Goal<Block>& goal, const Answers& now, unsigned inside, int first, Known& known) {
    constexpr unsigned all = (1u << BLOCK) - 1;
    inside = inside >> first & all;
    if (!inside) return;
    Block q[6], start[6], chosen, moved = 0.0;
    for (int j = 0; j < 6; ++j) q[j] = start[j] = atan2(load<Block>(now.s[j] + first), load<Block>(now.c[j] + first));
    for (int l = 0; l < BLOCK; ++l) chosen.set(l, inside >> l & 1);
    const Polished<Block> end = polish<false>(arm.written, goal, q, {5, CONVERGED, 2}, chosen > Block(0.5));
    for (int j = 0; j < 6; ++j) moved = max(moved, abs(wrap(q[j] - start[j])));
    const unsigned found = inside & bits((end.error <= Block(CONVERGED)) & (moved <= 0.5 * end.least) &
                                         (end.least >= Block(arm.written.tolerances.singular)));
    known.found |= found << first, known.open &= ~(found << first);
    for (int l = 0; l < BLOCK; ++l) {
        for (int j = 0; j < 6 && found >> l & 1; ++j) known.angle[j][first + l] = q[j][l];
    }
}

// Corrects the targets of all branches once more, then decides the open branches where this is possible.
PART void decide(const BothArms& arm, const Goal<Block>& goal, const IdealAnswer& family, Answers& now, Known& known) {
    const Answers before = now;
    double square[8];
    for (int first = 0; first < 8; first += BLOCK) {
        Turn<Block> turn[6];
        for (int j = 0; j < 6; ++j) turn[j] = {load<Block>(before.c[j] + first), load<Block>(before.s[j] + first)};
        family.answer(family.arm, corrected(arm, goal, turn), first, now);
        Block most = 0.0;
        for (int j = 0; j < 6; ++j) {
            const Block c = load<Block>(now.c[j] + first) - turn[j].c, s = load<Block>(now.s[j] + first) - turn[j].s;
            most = max(most, c * c + s * s);
        }
        store(most, square + first);
    }
    const double fixed = FIXED_BY_DRIFT * arm.drift;
    unsigned inside = 0;
    for (int b = 0; b < 8; ++b) {
        if (!(known.open >> b & 1) || !(now.arms[b] >= fixed * fixed)) continue;
        if (is_beyond(before, now, b, square[b], arm.drift)) known.open &= ~(1u << b);
        else if (min(now.margin[0][b], min(now.margin[1][b], now.margin[2][b])) > 0.0) inside |= 1u << b;
    }
    for (int first = 0; first < 8; first += BLOCK) follow(arm, goal, now, inside, first, known);
}

// One bit per branch: in `found` if it is a solution, in `open` if it is undecided.
Known decide_all(const BothArms& arm, const Seen<double>& seen, const IdealAnswer& family, Known known) {
    const Goal<Block> target = spread<Block>({seen.R, seen.p});
    Answers now;
    for (int first = 0; first < 8; first += BLOCK) family.answer(family.arm, {target.R, target.p}, first, now);
    for (int round = 0; round < CORRECTIONS && known.open; ++round) decide(arm, target, family, now, known);
    for (const double each : now.arms) known.least_arm = min(known.least_arm, each);
    return known;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
