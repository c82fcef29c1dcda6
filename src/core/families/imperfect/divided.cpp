// See divided.hpp. Compiled once for every instruction set.
#include "families/imperfect/divided.hpp"

#include "certificate/cluster.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Boxes that are looked at before a pose is left open, and boxes that may wait: where more wait, they hardly shrink. None of the
// numbers here decides what is proven.
inline constexpr int MOST_BOXES = 2400, WAITING = 64;
// A box that keeps more than this share of its widths has stopped to shrink.
inline constexpr double SHRUNK = 0.7;
// Half the width [rad] of a box below which a region about a singular root is looked for, and how many times.
inline constexpr double NEAR_A_ROOT = 0.06;
inline constexpr int REGIONS = 256, LOOKS = 256;
// It is looked for again in boxes narrower by this factor, and a pose is left open where a box of half this width [rad] is.
inline constexpr double NARROWER = 0.4, NARROWEST = 1e-10;
// A leading joint is halved first where it is at least this share of the widest.
inline constexpr double LEADS = 0.3;
// Rounding of an arc's ends [rad].
inline constexpr double ROUNDED_ARC = 4e-15;

// Angles include the ideal arm's offsets.
struct Box {
    double middle[6], half[6];
    double look;  // a region is looked for when the box is narrower than this
    int branch;
};

// A region that holds the roots that were found in it, and no others: |across| and |along| from its centre.
struct Surroundings {
    double q[6], direction[6][6], across, along;
};

// Whether a box of joint values lies in the region.
STEP bool holds(const Surroundings& region, const double (&q)[6], const double (&half)[6]) {
    double d[6], across = 0.0, along = 0.0;
    for (int j = 0; j < 6; ++j) d[j] = wrap(wrap(q[j] - region.q[j]));
    for (int k = 0; k < 6; ++k) {
        double middle = 0.0, wide = 1e-14;
        for (int j = 0; j < 6; ++j) middle += region.direction[k][j] * d[j], wide += abs(region.direction[k][j]) * half[j];
        if (k == 5) along = abs(middle) + wide;
        else across += square(abs(middle) + wide);
    }
    return along <= region.along && across <= region.across * region.across;
}

struct Divider {
    const Division& of;
    Certified& out;
    Box box[WAITING + BLOCK];
    int waiting = 0;
    Surroundings region[REGIONS];
    int regions = 0, tried = 0;
    bool blurred = false;

    Divider(const Division& all, Certified& to) : of(all), out(to) {}

    void values_of(const Box& each, double (&q)[6]) const {
        for (int j = 0; j < 6; ++j) q[j] = wrap(wrap(each.middle[j] - of.ideal.offset[j]));
    }

    bool is_decided(const Box& each) const {
        double q[6];
        values_of(each, q);
        for (int i = 0; i < out.many; ++i) {
            double most = 0.0;
            for (int j = 0; j < 6; ++j) most = max(most, abs(wrap(wrap(q[j] - out.root[i].q[j]))) + each.half[j]);
            if (most < out.root[i].radius) return true;
        }
        for (int i = 0; i < regions; ++i) {
            if (holds(region[i], q, each.half)) return true;
        }
        return false;
    }

    void keep_region(const double (&q)[6], const Number (&direction)[6][6], double across, double along) {
        Surroundings& to = region[regions++];
        for (int k = 0; k < 6; ++k) {
            to.q[k] = q[k];
            for (int j = 0; j < 6; ++j) to.direction[k][j] = direction[k][j].re;
        }
        to.across = across, to.along = along;
    }
    // Whether q lies in a region; its roots are known.
    bool is_in_region(const double (&q)[6]) const {
        const double point[6] = {};
        for (int i = 0; i < regions; ++i) {
            if (holds(region[i], q, point)) return true;
        }
        return false;
    }

    // A region with one root near q, which keeps the pose. Returns whether there is one, and how far it reaches.
    bool one_root(const double (&q)[6], Region& found, Local& at) const {
        Number from[6];
        for (int k = 0; k < 6; ++k) from[k] = q[k];
        const LoopAt<Number> here = loop_at(of.loop, from);
        decompose(here, at.J);
        localise(of.loop, here, from, at);
        found = ball_of(at, 1, Holds::one);
        return found.along > 0.0;
    }

    // Whether a region without roots holds the box: about the point of its curve of least error that is next to its middle.
    bool no_root(const Box& each, const double (&start)[6]) {
        Number q[6];
        for (int k = 0; k < 6; ++k) q[k] = start[k];
        Local at;
        for (int round = 0;; ++round) {
            const LoopAt<Number> here = loop_at(of.loop, q);
            decompose(here, at.J);
            if (!(at.J.s[5] < WEAK * at.J.s[0])) return false;
            Number next[6];
            for (int k = 0; k < 6; ++k) next[k] = q[k];
            const double step = step_across(here, at.J, 1, next);
            if (!(step < FARTHEST_CENTRE)) return false;
            if (step <= ACROSS) {
                localise(of.loop, here, q, at);
                break;
            }
            if (round == 6) return false;
            for (int k = 0; k < 6; ++k) q[k] = next[k];
        }
        const Region found = ball_of(at, 1, Holds::none);
        if (!(found.along > 0.0)) return false;
        double centre[6];
        for (int k = 0; k < 6; ++k) centre[k] = q[k].re;
        keep_region(centre, at.J.right, found.largest_across, found.largest_along);
        if (holds(region[regions - 1], start, each.half)) return true;
        --regions;
        return false;
    }

    // Looks for a region about a singular root, or a pair of them, near the box.
    void look_near(const Box& each) {
        if (tried >= LOOKS || regions == REGIONS) return;
        ++tried;
        double q[6], start[6];
        values_of(each, start);
        if (no_root(each, start)) return;
        for (int j = 0; j < 6; ++j) q[j] = start[j];
        const double error = polish_one<true>(of.written, of.goal, q, {40, FINISHED, LONG_PATIENCE}).error;
        double far = 0.0;
        for (int j = 0; j < 6; ++j) far = max(far, abs(wrap(wrap(q[j] - start[j]))));
        if (far > 0.2) return;
        if (is_in_region(q)) return;
        Number from[6];
        for (int k = 0; k < 6; ++k) from[k] = q[k];
        Cluster pair;
        if (cluster_near(of.loop, from, 1, pair) && add_pair_of_roots(pair, each.branch)) return;
        Region found;
        Local at;
        if (error <= CONVERGED && one_root(q, found, at)) {
            // A root that was certified before may be this one.
            const double half[6] = {};
            keep_region(q, at.J.right, found.largest_across, found.largest_along);
            for (int i = 0; i < out.many; ++i) {
                if (holds(region[regions - 1], out.root[i].q, half)) return;
            }
            out.add(q, 0.0, each.branch, true);
        }
    }

    // Two roots: both are found, or none is real, or they stand as one. Returns false where none of this is certain.
    bool add_pair_of_roots(const Cluster& pair, int branch) {
        double centre[6];
        for (int k = 0; k < 6; ++k) centre[k] = wrap(wrap(pair.q[k].re));
        Surroundings all = {};
        for (int k = 0; k < 6; ++k) {
            all.q[k] = centre[k];
            for (int j = 0; j < 6; ++j) all.direction[k][j] = pair.direction[k][j].re;
        }
        all.across = pair.larger_across, all.along = pair.larger_along;
        const double point[6] = {};
        double q[2][6];
        int good = 0;
        Region found[2];
        Local at;
        for (int i = 0; i < pair.starts; ++i) {
            for (int j = 0; j < 6; ++j) q[good][j] = pair.start[i][j];
            const Course course = {12, FINISHED, 12};
            if (polish_one<false>(of.written, of.goal, q[good], course).error > CONVERGED) continue;
            if (!holds(all, q[good], point) || !one_root(q[good], found[good], at)) continue;
            ++good;
        }
        double between = 0.0;
        for (int j = 0; j < 6 && good == 2; ++j) between += square(wrap(wrap(q[0][j] - q[1][j])));
        const auto radius = [](const Region& r) { return sqrt(r.across * r.across + r.along * r.along); };
        const bool both = good == 2 && sqrt(between) > radius(found[0]) + radius(found[1]) + 1e-14;
        if (!both && !pair.blurred && !pair.apart) return false;
        int kept = 0;
        for (int i = 0; i < out.many; ++i) {
            if (!holds(all, out.root[i].q, point)) out.root[kept++] = out.root[i];
        }
        out.many = kept;
        region[regions++] = all;
        if (both) {
            for (int i = 0; i < 2; ++i) out.add(q[i], 0.0, branch, true);
            return true;
        }
        if (pair.apart) return true;
        const Course held = {8, FINISHED, LONG_PATIENCE, HELD};
        if (polish_one<true>(of.written, of.goal, centre, held).error <= of.written.tolerances.reach) {
            out.add(centre, 0.0, branch, true), blurred = true;
            return true;
        }
        --regions;
        return false;
    }

    // Puts a box back in two halves. Returns whether there is room.
    bool halve(const Box& each) {
        const Displacement& apart = of.ideal.displacement;
        const double size = of.ideal.size;
        int widest = 0;
        double most = -1.0;
        for (int j = 0; j < 6; ++j) {
            const double weight = apart.turn[j + 1] * (1.0 + apart.length[j + 1] / size) + apart.shift[j + 1] / size;
            const double moves = (weight + 1e-12) * each.half[j];
            if (moves > most) most = moves, widest = j;
        }
        double wide = 0.0;
        for (const double half : each.half) wide = max(wide, half);
        for (int k = 2; k >= 0; --k) {
            const int j = of.family.leading[k];
            if (each.half[j] >= LEADS * wide && wide > NEAR_A_ROOT) widest = j;
        }
        if (waiting + 2 > WAITING) return false;
        for (int side = -1; side <= 1; side += 2) {
            Box& to = box[waiting++];
            to = each;
            to.half[widest] = 0.5 * each.half[widest] + ROUNDED_ARC;
            to.middle[widest] = wrap(each.middle[widest] + side * 0.5 * each.half[widest]);
        }
        return true;
    }

    // The next arcs of the last boxes that wait, up to a block. Returns false if a box has to be left open.
    bool step() {
        const int many = waiting < BLOCK ? waiting : BLOCK;
        waiting -= many;
        Box now[BLOCK];
        Block middle[6], half[6], sign[3];
        for (int l = 0; l < BLOCK; ++l) {
            now[l] = box[waiting + (l < many ? l : 0)];
            for (int j = 0; j < 6; ++j) middle[j].set(l, now[l].middle[j]), half[j].set(l, now[l].half[j]);
            for (int k = 0; k < 3; ++k) sign[k].set(l, of.ideal.signs[k][now[l].branch]);
        }
        Turn<Block> turn[6];
        Block chord[6];
        Arcs<Ball<Block>> known;
        for (int j = 0; j < 6; ++j) {
            turn[j] = cos_sin(middle[j]), chord[j] = min(half[j] + ROUNDED_ARC, Block(2.0));
            known.of[j] = {{turn[j].c, chord[j]}, {turn[j].s, chord[j]}};
        }
        const Targets targets = targets_of(of.both, of.ideal.displacement, of.target, turn, chord, half);
        BoxBlock next;
        of.family.within(of.family.arm, targets.middle, targets.turn, targets.shift, {sign[0], sign[1], sign[2]}, known, next);
        Block before = 0.0, after = 0.0, widest = 0.0, q[6];
        auto empty = before > Block(1.0);
        for (int j = 0; j < 6; ++j) {
            const auto arc = next.c[j] * next.c[j] + next.s[j] * next.s[j] > Block(0.5);
            const Block x = next.chord[j], wide = select(arc, x + 0.056 * x * x * x + ROUNDED_ARC, Block(7.0));
            const Block d = wrap(wrap(atan2(next.s[j], next.c[j]) - middle[j]));
            // Arcs that together go around the circle may meet twice: the shorter one is taken.
            const auto twice = wide + half[j] + abs(d) > Block(6.28), shorter = wide < half[j];
            const Block low = select(twice, select(shorter, d - wide, -half[j]), max(-half[j], d - wide));
            const Block high = select(twice, select(shorter, d + wide, half[j]), min(half[j], d + wide));
            empty = empty | (low > high + ROUNDED_ARC);
            before += half[j];
            middle[j] = wrap(middle[j] + 0.5 * (low + high));
            half[j] = max(0.5 * (high - low), Block(0.0)) + ROUNDED_ARC;
            after += half[j], widest = max(widest, half[j]);
            q[j] = wrap(wrap(middle[j] - of.ideal.offset[j]));
        }
        const unsigned lanes = (1u << many) - 1, gone = bits(empty) | next.empty;
        const unsigned shrunk = bits(after < SHRUNK * before);
        unsigned left = lanes & ~gone;
        for (unsigned rest = left; rest; rest &= rest - 1) {
            const int l = __builtin_ctz(rest);
            for (int j = 0; j < 6; ++j) now[l].middle[j] = middle[j][l], now[l].half[j] = half[j][l];
            if (is_decided(now[l])) left &= ~(1u << l);
        }
        const unsigned ready = left & ~shrunk & bits(widest <= Block(WIDEST_BOX));
        if (ready) {
            const Rooted root = root_of(of.loop, q, widest, ready);
            left &= ~root.found;
            for (unsigned rest = root.found; rest; rest &= rest - 1) {
                const int l = __builtin_ctz(rest);
                double at[6];
                for (int j = 0; j < 6; ++j) at[j] = root.q[j][l];
                if (!is_in_region(at)) out.add(at, root.radius[l], now[l].branch, false);
            }
        }
        for (unsigned rest = left; rest; rest &= rest - 1) {
            const int l = __builtin_ctz(rest);
            if (shrunk >> l & 1) {
                box[waiting++] = now[l];
                continue;
            }
            if (is_decided(now[l])) continue;
            if (widest[l] < now[l].look) {
                look_near(now[l]);
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
            to.middle[j] = arc ? atan2(s, c) : 0.0, to.half[j] = arc ? x + 0.056 * x * x * x + ROUNDED_ARC : PI;
        }
    }
    for (int k = 0; k < MOST_BOXES; k += BLOCK) {
        if (!divider.waiting) {
            out.status = divider.blurred ? Status::clustered : Status::complete;
            return;
        }
        if (!divider.step()) return;
    }
}

}  // namespace urdf_ik::URDF_IK_LEVEL
