// See certified.hpp. Compiled once for every instruction set.
#include "families/imperfect/certified.hpp"

#include "certificate/single.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Half the width [rad] of the widest box from which a root can be shown to be alone: the norm of each joint's twist is at least
// sqrt(2), and S r in certificate/single.hpp at most LARGEST_BALL.
inline constexpr double WIDEST_BOX = LARGEST_BALL / (6.0 * 1.414);
// Newton's steps from the centre of a box to where a root is certified. One more, with the same factors, gives the solution.
inline constexpr int STEPS = 2;

// A block of boxes: half the width of its widest arc [rad], infinite for a whole circle, and its centre as joint values. An arc's
// chord x belongs to the angle 2 asin(x / 2) <= x (1 + 0.056 x^2), up to a half circle, where x^2 = 2.
struct Middle {
    Block q[6], width;
};
STEP Middle middle_of(const Boxes& boxes, const IdealFrames& ideal, int first) {
    Middle out;
    out.width = 0.0;
    for (int j = 0; j < 6; ++j) {
        const Block c = load<Block>(boxes.c[j] + first), s = load<Block>(boxes.s[j] + first), x = load<Block>(boxes.chord[j] + first);
        out.q[j] = wrap(atan2(s, c) - ideal.offset[j]);
        out.width = max(out.width, select(c * c + s * s > Block(0.5), x + 0.056 * x * x * x, Block(__builtin_inf())));
    }
    return out;
}

PART void certify_boxes(const IdealFrames& ideal, const Loop& loop, const Boxes& boxes, int first, Known& known,
                        double (&radii)[8]) {
    constexpr unsigned all = (1u << BLOCK) - 1;
    const Middle box = middle_of(boxes, ideal, first);
    const unsigned open = known.open >> first & all & bits(box.width <= Block(WIDEST_BOX));
    if (!open) return;
    // The other lanes repeat a box, so that they cost nothing more.
    const int one = __builtin_ctz(open);
    Block q[6], width = box.width;
    for (int j = 0; j < 6; ++j) q[j] = box.q[j];
    for (int l = 0; l < BLOCK; ++l) {
        if (open >> l & 1) continue;
        width.set(l, box.width[one]);
        for (int j = 0; j < 6; ++j) q[j].set(l, box.q[j][one]);
    }
    Turn<Block> turn[6];
    Orthogonal<Block> factors;
    LoopAt<Block> at;
    Block moved[6];
    for (Block& each : moved) each = 0.0;
    const auto step = [&] {
        const Six<Block> x = newton_step(factors, at.error);
        for (int j = 0; j < 6; ++j) q[j] = wrap(q[j] + x[j]), moved[j] = moved[j] + x[j];
    };
    for (int k = 0; k < STEPS; ++k) {
        turns_of(q, turn);
        at = loop_at(loop, turn);
        make_orthogonal(at.twist, factors);
        step();
    }
    Block far = 0.0;
    for (int j = 0; j < 6; ++j) far = max(far, abs(moved[j]));
    const Block radius = INFLATED * (width + far);
    turns_of(q, turn);
    at = loop_at(loop, turn);
    const Certificate root = certify(loop, at, factors, growth_of(q), radius);
    step();
    turns_of(q, turn);
    const auto converged = largest(loop_at(loop, turn).error) <= Block(CONVERGED);
    const unsigned found = open & bits(root.holds & (root.outer >= radius) & converged);
    known.found |= found << first, known.open &= ~(found << first);
    store(radius, radii + first);
    for (int j = 0; j < 6; ++j) store(q[j] + Block(ideal.offset[j]), known.angle[j] + first);
}

Known certify_all(const Written<6>& written, const IdealFrames& ideal, const Goal<double>& goal, const Seen<double>& seen,
                  const Inclusion& family) {
    const Goal<Block> target = spread<Block>({seen.R, seen.p});
    const auto& [turn, shift, length] = ideal.displacement;
    const double far = ideal.size + sqrt(dot(seen.p, seen.p));
    const Loop loop = loop_of(written, goal);
    Boxes boxes;
    Known known;
    double radii[8];
    for (int first = 0; first < 8; first += BLOCK) {
        family.include(family.arm, {target.R, target.p}, turn[0] + TARGET_ROUNDING, shift[0] + TARGET_ROUNDING * far, first, boxes);
        known.open &= ~boxes.empty;
        certify_boxes(ideal, loop, boxes, first, known, radii);
    }
    // Two boxes may lead to one root, which is the only one within either's radius.
    for (int b = 1; b < 8; ++b) {
        for (int a = 0; a < b && known.found >> b & 1; ++a) {
            double apart = 0.0;
            for (int j = 0; j < 6; ++j) apart = max(apart, abs(wrap(wrap(known.angle[j][a] - known.angle[j][b]))));
            if (known.found >> a & 1 && apart <= max(radii[a], radii[b])) known.found &= ~(1u << b);
        }
    }
    return known;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
