// See divided.hpp. Compiled once for every instruction set.
#include "families/imperfect/divided.hpp"

#include "answers/on_curve.hpp"
#include "families/imperfect/surroundings.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Boxes that may wait: where more wait, they hardly shrink. None of the numbers here decides what is proven. Of 979 poses at and
// beside singularities of rounded arms that end proven none had more than 85 waiting boxes, and of 195 that do not end half had.
inline constexpr int WAITING = 100;
// A look for a region counts as so many boxes. It takes as long as 50, but ends sooner what it decides.
inline constexpr int BOXES_OF_A_LOOK = 8;
// A box that keeps more than this share of its widths has stopped to shrink.
inline constexpr double SHRUNK = 0.7;
// Half the width [rad] of a box below which a region about a singular root is looked for (most boxes end empty above it), how many
// regions are kept, and how often none may be found before a pose is left open: one of 1,380 poses that end proven had more than
// five looks in vain (145), and of those that do not end three in four had.
inline constexpr double NEAR_A_ROOT = 0.01;
inline constexpr int REGIONS = 256, PATCHES = 64, LOOKS_IN_VAIN = 8;
// It is looked for again in boxes narrower by this factor, and a pose is left open where a box of half this width [rad] is.
inline constexpr double NARROWER = 0.4, NARROWEST = 1e-10;
inline constexpr int ROUNDS_TO_VALLEY = 10;
// A leading joint is halved first where it is at least this share of the widest.
inline constexpr double LEADS = 0.02;
// Boxes hold every joint vector that keeps the pose to Tolerances::reach in each number: a pair that is not real by less does not
// empty a box.
inline constexpr double KEPT = 1.8e-10;
// Rounding of an arc's ends [rad].
inline constexpr double ROUNDED_ARC = 4e-15;

// Joint angles within `rest` of middle + along t, |t| <= 1; they include the ideal arm's offsets.
struct Box {
    double middle[6], along[6], rest[6];
    double look;  // a region is looked for when the box is smaller than this
    int branch;

    STEP double half(int j) const { return abs(along[j]) + rest[j]; }
};

struct Divider {
    const Division& of;
    Certified& out;
    Box box[WAITING + BLOCK];
    int waiting = 0;
    Surroundings region[REGIONS];  // the last ones, in a ring
    Patch patch[PATCHES];
    int regions = 0, patches = 0, in_vain = 0, work = 0;  // work: in boxes
    bool blurred = false, lost = false;  // lost: whether a root found no room, or may be another one
    bool on_curve = false;               // whether what stands for others lies on a curve of solutions

    Divider(const Division& all, Certified& to) : of(all), out(to) {}

    void values_of(const Box& each, double (&q)[6]) const {
        for (int j = 0; j < 6; ++j) q[j] = wrap(wrap(each.middle[j] - of.ideal.offset[j]));
    }

    bool is_decided(const Box& each) const {
        double q[6];
        values_of(each, q);
        for (int i = 0; i < out.many; ++i) {
            double most = 0.0;
            for (int j = 0; j < 6; ++j) most = max(most, abs(wrap(wrap(q[j] - out.root[i].q[j]))) + each.half(j));
            if (most < out.root[i].radius) return true;
        }
        return is_in_region(q, each.along, each.rest);
    }

    static void region_at(const Local& at, const Valley& valley, double across, double low, double high, Surroundings& to) {
        for (int k = 0; k < 6; ++k) {
            to.q[k] = wrap(wrap(at.q[k].re));
            for (int j = 0; j < 6; ++j) to.direction[k][j] = at.J.right[k][j].re;
        }
        to.across = across, to.low = low, to.high = high, to.valley = valley;
        const double along = max(-low, high);
        to.farthest = INFLATED * (along + across + valley.height(along));
    }
    // Whether joint vectors lie in a region; its roots are known.
    bool is_in_region(const double (&q)[6], const double (&along)[6] = {}, const double (&rest)[6] = {}) const {
        for (int i = (regions < REGIONS ? regions : REGIONS) - 1; i >= 0; --i) {
            if (placed(region[i], q, along, rest).inside) return true;
        }
        double t[2];
        for (int i = (patches < PATCHES ? patches : PATCHES) - 1; i >= 0; --i) {
            if (patch[i].holds(q, along, rest, t)) return true;
        }
        return false;
    }

    // The point next to q at which f vanishes but in the directions of the `lost` smallest singular values, by the derivative
    // there, and the numbers at it. Returns whether there is one.
    bool step_across_to(const double (&start)[6], int lost, Local& at) const {
        Number q[6];
        for (int k = 0; k < 6; ++k) q[k] = start[k];
        for (int round = 0; round < ROUNDS_TO_VALLEY; ++round) {
            LoopAt<Number> here = loop_at(of.loop, q);
            if (round == 0) decompose(here, at.J);
            if (!(at.J.s[6 - lost] < WEAK * at.J.s[0])) return false;
            const double step = step_across(here, at.J, lost, q);
            if (!(step < FARTHEST_CENTRE)) return false;
            for (Number& each : q) each = wrap(wrap(each.re));
            if (step > ACROSS) continue;
            here = loop_at(of.loop, q);
            decompose(here, at.J), localise(of.loop, here, q, at);
            return true;
        }
        return false;
    }

    // Whether a region about the valley next to a joint vector is found, whose roots are known. It may not hold the joint vector.
    bool on_valley(const double (&start)[6], int branch) {
        Local at;
        Valley valley;
        Reduced bounds;
        Crossings found;
        if (!step_across_to(start, 1, at)) return false;
        follow_valley(at, true, valley);
        if (!reduce<1>(at, norms_of(at, 1), valley, bounds) || !crossings_of(valley, bounds, at.rounding, found)) return false;
        Surroundings all;
        region_at(at, valley, bounds.across, found.low, found.high, all);
        if (!has_roots(all, found, branch)) return false;
        region[regions++ % REGIONS] = all;
        return true;
    }
    // The same about a surface, where two ranks are lost, at least as wide as `least` to either side.
    bool on_surface(const double (&start)[6], double least, int branch) {
        Local at;
        OnSurface surface;
        Reduced bounds;
        Zeros found;
        Patch all;
        if (!step_across_to(start, 2, at)) return false;
        follow<2, double>(at, true, surface);
        if (!reduce<2>(at, norms_of(at, 2), surface, bounds)) return false;
        if (!zeros_on_surface(surface, bounds, at.rounding, least, found)) return false;
        for (int k = 0; k < 6; ++k) {
            all.q[k] = wrap(wrap(at.q[k].re));
            for (int j = 0; j < 6; ++j) all.direction[k][j] = at.J.right[k][j].re;
        }
        all.surface = surface;
        all.across = bounds.across, all.along = found.along;
        const double along = 1.5 * found.along;
        all.farthest = INFLATED * (along + all.across + surface.height(along));
        double q[Zeros::most][6], t[2];
        for (int i = 0; i < found.many; ++i) {
            const Zero& each = found.at[i];
            all.at(each.t, q[i]);
            if (!is_solved(q[i], each.single) || !all.holds(q[i], {}, {}, t)) return false;
            if (!each.holds(t)) return false;
            on_curve |= each.crosses && is_on_curve(of.written, of.goal, q[i]);
        }
        const auto is_inside = [&](const double (&root)[6]) { return all.holds(root, {}, {}, t); };
        const auto is_again = [&](const double (&)[6]) {
            bool again = false;
            for (int i = 0; i < found.many; ++i) again |= found.at[i].holds(t);
            return again;
        };
        if (!forget(is_inside, is_again)) return false;
        for (int i = 0; i < found.many; ++i) keep_root(q[i], branch, found.at[i].single);
        patch[patches++ % PATCHES] = all;
        return true;
    }
    // Whether Newton's method from q leads to a solution, or, where one joint vector stands for others, to one that keeps the pose.
    bool is_solved(double (&q)[6], bool single) const {
        if (single) return polish_one<false>(of.written, of.goal, q, {12, FINISHED, 12}).error <= CONVERGED;
        return polish_one<true>(of.written, of.goal, q, ACROSS_A_VALLEY).error <= of.written.tolerances.reach;
    }

    // Finds the roots in a region. Returns false where one is not found.
    bool has_roots(const Surroundings& all, const Crossings& found, int branch) {
        double q[Crossings::most][6];
        for (int i = 0; i < found.many; ++i) {
            const Crossing& each = found.at[i];
            double y[5];
            all.valley.at(each.t, y);
            for (int j = 0; j < 6; ++j) {
                double sum = all.q[j] + each.t * all.direction[5][j];
                for (int k = 0; k < 5; ++k) sum += y[k] * all.direction[k][j];
                q[i][j] = wrap(wrap(sum));
            }
            if (!is_solved(q[i], each.single)) return false;
            const Placed where = placed(all, q[i]);
            if (!where.inside || where.along < each.low || where.along > each.high) return false;
        }
        const auto is_again = [&](const double (&root)[6]) {
            const double t = placed(all, root).along;
            bool again = false;
            for (int k = 0; k < found.many; ++k) again |= t >= found.at[k].low && t <= found.at[k].high;
            return again;
        };
        if (!forget([&](const double (&root)[6]) { return holds(all, root); }, is_again)) return false;
        for (int i = 0; i < found.many; ++i) keep_root(q[i], branch, found.at[i].single);
        return true;
    }
    void keep_root(const double (&q)[6], int branch, bool single) {
        if (out.add(q, 0.0, branch, true)) out.root[out.many - 1].stands = !single;
        else lost = true;
        blurred |= !single;
    }
    // Removes the known roots in a region that have been found again. What stands for others stays: they may lie outside. Returns
    // false where another one has not been found.
    bool forget(const auto& is_inside, const auto& is_again) {
        int kept = 0;
        Certified::Root left[Certified::most];
        for (int i = 0; i < out.many; ++i) {
            const bool inside = is_inside(out.root[i].q), again = inside && is_again(out.root[i].q);
            if (inside && !again && !out.root[i].stands) return false;
            if (!again) left[kept++] = out.root[i];
        }
        for (int i = 0; i < kept; ++i) out.root[i] = left[i];
        out.many = kept;
        return true;
    }

    // Looks for a region near the box: about the valley next to its middle, or about where Newton's method leads to.
    void look_near(const Box& each, double wide) {
        double q[6], start[6];
        values_of(each, start);
        const auto is_found = [&](bool found) { return found && is_decided(each); };
        if (is_found(on_valley(start, each.branch)) || is_found(on_surface(start, wide, each.branch))) return;
        for (int j = 0; j < 6; ++j) q[j] = start[j];
        polish_one<true>(of.written, of.goal, q, {40, FINISHED, LONG_PATIENCE});
        double far = 0.0;
        for (int j = 0; j < 6; ++j) far = max(far, abs(wrap(wrap(q[j] - start[j]))));
        if (far > 0.2 || is_in_region(q)) return;
        if (!is_found(on_valley(q, each.branch))) on_surface(q, wide, each.branch);
    }

    // The joint along which a box is halved.
    int widest_of(const Box& each) const {
        const Displacement& apart = of.ideal.displacement;
        const double size = of.ideal.size;
        int widest = 0;
        double most = -1.0, wide = 0.0;
        for (int j = 0; j < 6; ++j) {
            const double weight = apart.turn[j + 1] * (1.0 + apart.length[j + 1] / size) + apart.shift[j + 1] / size;
            const double moves = (weight + 1e-12) * each.half(j);
            if (moves > most) most = moves, widest = j;
            wide = max(wide, each.half(j));
        }
        for (int k = 2; k >= 0; --k) {
            const int j = of.family.leading[k];
            if (each.half(j) >= LEADS * wide && wide > NEAR_A_ROOT) widest = j;
        }
        return widest;
    }
    // Puts a box back in two halves. Returns whether there is room.
    bool halve(Box each) {
        const int j = widest_of(each);
        if (waiting + 2 > WAITING) return false;
        if (abs(each.along[j]) < each.rest[j]) {
            // From now on the box is slanted along this joint.
            for (int k = 0; k < 6; ++k) each.rest[k] = each.half(k), each.along[k] = 0.0;
            each.along[j] = each.rest[j], each.rest[j] = 0.0;
        }
        for (int side = -1; side <= 1; side += 2) {
            Box& to = box[waiting++];
            to = each;
            shorten(to, 0.5 * side, 0.5);
        }
        return true;
    }
    // The part within `size` of t = `at`.
    static void shorten(Box& each, double at, double size) {
        for (int j = 0; j < 6; ++j) {
            each.middle[j] = wrap(each.middle[j] + at * each.along[j]);
            each.along[j] *= size, each.rest[j] += ROUNDED_ARC;
        }
    }

    // The next arcs of the last boxes that wait, up to a block. Returns false if a box has to be left open.
    bool step() {
        const int many = waiting < BLOCK ? waiting : BLOCK;
        waiting -= many, work += many;
        Box now[BLOCK];
        Block middle[6], along[6], rest[6], sign[3];
        for (int l = 0; l < BLOCK; ++l) {
            now[l] = box[waiting + (l < many ? l : 0)];
            for (int j = 0; j < 6; ++j) {
                middle[j].set(l, now[l].middle[j]), along[j].set(l, now[l].along[j]), rest[j].set(l, now[l].rest[j]);
            }
            for (int k = 0; k < 3; ++k) sign[k].set(l, of.ideal.signs[k][now[l].branch]);
        }
        Turn<Block> turn[6];
        Block chord[6];
        Arcs<Block> known;
        for (int j = 0; j < 6; ++j) {
            turn[j] = cos_sin(middle[j]);
            const Block off = min(rest[j] + ROUNDED_ARC, Block(2.0)), a = abs(along[j]);
            chord[j] = min(a + rest[j] + ROUNDED_ARC, Block(2.0));
            // The turn moves by the sine of along t, less its square: the cosine and the sine of what is within `rest` of the
            // middle change by `rest` at most.
            const Block change = a * (0.5 * a + 0.17 * a * a + off);
            known.of[j] = {{{turn[j].c, off}, {-turn[j].s * along[j], change}, {turn[j].c, chord[j]}},
                           {{turn[j].s, off}, {turn[j].c * along[j], change}, {turn[j].s, chord[j]}}};
            known.of[j].c.all = {turn[j].c, chord[j]}, known.of[j].s.all = {turn[j].s, chord[j]};  // one disc
        }
        Targets targets = targets_of(of.both, of.ideal.displacement, of.target, turn, chord, along, rest);
        targets.turn += KEPT, targets.shift += KEPT * of.ideal.size;
        BoxBlock next;
        of.family.within(of.family.arm, targets, {sign[0], sign[1], sign[2]}, known, next);
        Block before = 0.0, after = 0.0, widest = 0.0, q[6];
        auto empty = next.low > next.high;
        const Block at = 0.5 * (next.low + next.high), part = 0.5 * (next.high - next.low) + 1e-14;
        for (int j = 0; j < 6; ++j) {
            const auto arc = next.c[j] * next.c[j] + next.s[j] * next.s[j] > Block(0.5);
            const Block x = next.chord[j], half = abs(along[j]) + rest[j];
            const Block wide = select(arc & (x < Block(1.4)), half_angle(x) + ROUNDED_ARC, Block(7.0));
            // The new slanted arc and the old one are met at the same t, so is the new arc itself.
            const Block off = wrap(wrap(next.middle[j] - middle[j])), apart = abs(off) - abs(next.along[j] - along[j]);
            const Block d = wrap(wrap(atan2(next.s[j], next.c[j]) - middle[j]));
            empty = empty | (apart > next.rest[j] + rest[j] + ROUNDED_ARC) | (abs(d) > wide + half + ROUNDED_ARC);
            before += half;
            const auto slanted = next.rest[j] < rest[j];
            middle[j] = select(slanted, middle[j] + off, middle[j]), along[j] = select(slanted, next.along[j], along[j]);
            rest[j] = select(slanted, next.rest[j], rest[j]);
            // Only the parts of the arcs at these t.
            const auto level = wide < SHRUNK * (abs(along[j]) * part + rest[j]);
            middle[j] = wrap(select(level, middle[j] - select(slanted, off, Block(0.0)) + d, middle[j] + at * along[j]));
            along[j] = select(level, Block(0.0), along[j] * part), rest[j] = select(level, wide, rest[j]) + ROUNDED_ARC;
            const Block left = abs(along[j]) + rest[j];
            after += left, widest = max(widest, left);
            q[j] = wrap(wrap(middle[j] - of.ideal.offset[j]));
        }
        const unsigned lanes = (1u << many) - 1, gone = bits(empty) | next.empty;
        const unsigned shrunk = bits(after < SHRUNK * before);
        unsigned left = lanes & ~gone;
        for (unsigned open = left; open; open &= open - 1) {
            const int l = __builtin_ctz(open);
            for (int j = 0; j < 6; ++j) {
                now[l].middle[j] = middle[j][l], now[l].along[j] = along[j][l], now[l].rest[j] = rest[j][l];
            }
            if (is_decided(now[l])) left &= ~(1u << l);
        }
        const unsigned ready = left & ~shrunk & bits(widest <= Block(WIDEST_BOX));
        if (ready) {
            const Rooted root = root_of(of.loop, q, widest, ready);
            left &= ~root.found;
            for (unsigned found = root.found; found; found &= found - 1) {
                const int l = __builtin_ctz(found);
                double at[6];
                for (int j = 0; j < 6; ++j) at[j] = root.q[j][l];
                if (!is_in_region(at)) out.add(at, root.radius[l], now[l].branch, false);
                lost |= out.many == Certified::most;
            }
        }
        for (unsigned open = left; open; open &= open - 1) {
            const int l = __builtin_ctz(open);
            if (shrunk >> l & 1) {
                box[waiting++] = now[l];
                continue;
            }
            if (is_decided(now[l])) continue;
            if (widest[l] < now[l].look) {
                const int before_look = regions + patches;
                look_near(now[l], widest[l]), work += BOXES_OF_A_LOOK;
                in_vain += regions + patches == before_look;
                if (in_vain > LOOKS_IN_VAIN || on_curve) return false;
                if (is_decided(now[l])) continue;
                now[l].look = NARROWER * widest[l];
            }
            if (widest[l] < NARROWEST) return false;
            if (!halve(now[l])) return false;
        }
        return true;
    }
};

void divide(const Division& of, const Boxes& boxes, unsigned open, Certified& out) {
    Divider divider(of, out);
    for (unsigned rest = open; rest; rest &= rest - 1) {
        const int b = __builtin_ctz(rest);
        Box& to = divider.box[divider.waiting++];
        to.branch = b, to.look = NEAR_A_ROOT;
        for (int j = 0; j < 6; ++j) {
            const double c = boxes.c[j][b], s = boxes.s[j][b], x = boxes.chord[j][b];
            const bool arc = c * c + s * s > 0.5;
            to.middle[j] = arc ? atan2(s, c) : 0.0, to.rest[j] = arc ? half_angle(x) + ROUNDED_ARC : PI, to.along[j] = 0.0;
        }
    }
    while (divider.work < of.both.boxes) {
        if (!divider.waiting) {
            if (divider.lost) return;
            out.status = divider.blurred ? Status::clustered : Status::complete;
            return;
        }
        if (!divider.step()) return;
    }
}

}  // namespace urdf_ik::URDF_IK_LEVEL
