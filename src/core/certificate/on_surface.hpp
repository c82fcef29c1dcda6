// The real solutions on a piece of a surface, where two ranks are all but lost, as the zeros of two functions of two numbers.
//
// With t = (t_1, t_2) in the directions of the two smallest singular values, and Y(t) the surface of valley.hpp on which f's first
// four outputs vanish up to a high order, the solutions near the surface are the zeros of F(t) = P(t) + e(t), with bounds on e for
// complex |t| <= R as in along_valley.hpp. On each complex line through t Cauchy's formula bounds the derivatives,
// |De(t) v| <= |v| max |e| / (R - |t|).
//
// A cell (cells.hpp), |x| <= h_1, |y| <= h_2, is cut in two until
//   F has no zero: one of its values exceeds its error, or one of those of M F, M an inverse of F' at its middle
//   M F' is within 1/2 of 1 in the cell of 2 h, in the norm of max |x| / h_1 and |y| / h_2. Then the step of Newton's method with M
//     contracts it by 1/2, and it has at most one zero: none in the cell if M F in the middle exceeds 3/2, and one in that of 2 h
//     if that is at most 1
//   F is rounding in all of it. Such cells that touch hold joint vectors that one stands for, if it keeps the pose
// Before, it is cut to where its linear part leaves a zero: that of M F, or that of one output alone, whose zeros lie about a line.
// The cell is then slanted along this line, so that few of them follow a curve on which one output vanishes and the other nearly
// does. No zero may lie near the side of the whole, nor meet a cell of the last kind. Such cells may go on beyond the side: what
// stands for them there is found by the squares there.
#pragma once

#include "certificate/cells.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

using OnSurface = Left<2>;

// Bounds on e and on |De v| / |v| in a cell.
struct Errors {
    Block of_value, of_slope;
};
// P's terms about c, and as functions of x, where t_1 = x + slant t_2.
PART void shift(Block (&p)[TERMS<2>], const Block (&c)[2]) {
    constexpr int N = ORDERS<2>;
    in_turn<0, N>([&](auto b) IN_PLACE {
        in_turn<0, N - b>([&](auto i) IN_PLACE {
            in_turn<0, N - decltype(b)::value - i>([&](auto k) IN_PLACE {
                constexpr int n = N - 1 - k, B = decltype(b)::value;
                p[term_of<2>(n, B)] += c[0] * p[term_of<2>(n + 1, B)];
            });
        });
    });
    in_turn<0, N>([&](auto a) IN_PLACE {
        in_turn<0, N - a>([&](auto i) IN_PLACE {
            in_turn<0, N - decltype(a)::value - i>([&](auto k) IN_PLACE {
                constexpr int n = N - 1 - k, B = n - decltype(a)::value;
                p[term_of<2>(n, B)] += c[1] * p[term_of<2>(n + 1, B + 1)];
            });
        });
    });
}
PART void lean(Block (&p)[TERMS<2>], const Block& slant) {
    in_turn<1, ORDERS<2> + 1>([&](auto n) IN_PLACE {
        in_turn<0, n>([&](auto i) IN_PLACE {
            in_turn<1, n - decltype(i)::value + 1>([&](auto b)
                                                       IN_PLACE { p[term_of<2>(n, b)] += slant * p[term_of<2>(n, b - 1)]; });
        });
    });
}

// Cells that are looked at in a square, and that may wait. They decide the cost, and how large a square is. At round poses of ten
// rounded arms 800 cells left 7.2 % of the poses open where 400 left 7.3 %.
inline constexpr int MOST_CELLS = 400, MOST_WAITING = 150;
// Zeros keep this share of the whole width from its sides.
inline constexpr double BAND = 0.05;
// Where errors of slopes are taken from a radius.
inline constexpr double WITHIN = 0.75;
// A cell without a zero is as small as need be where |F| is at most so many times what counts as zero.
inline constexpr double FLAT_CELL = 8.0;

struct SurfaceDivider {
    const OnSurface& f;
    const Reduced& bounds;
    double rounding;
    Zeros& out;
    Joined blurred, near;  // where F is rounding; without a zero where a joint vector may keep the pose to NEARLY_KEPT
    Cell waiting[MOST_WAITING];
    int many = 0;
    double whole = 0.0;  // all cells nearer than this are decided or wait
    double kept = 0.0;  // |F| that counts as zero where there is none
    double sum[ORDERS<2> + 1];  // of the absolute values of both outputs' terms, by order
    double slope_error[Reduced::most];  // where |t| is at most WITHIN of a radius

    SurfaceDivider(const OnSurface& surface, const Reduced& all, double of_loop, Zeros& to)
        : f(surface), bounds(all), rounding(of_loop), out(to) {
        for (int n = 0; n <= ORDERS<2>; ++n) {
            sum[n] = 0.0;
            for (int b = 0; b <= n; ++b) sum[n] += abs(f.value[0][term_of<2>(n, b)]) + abs(f.value[1][term_of<2>(n, b)]);
        }
        for (int k = 0; k < bounds.many; ++k) slope_error[k] = bounds.error[k] / ((1.0 - WITHIN) * bounds.radius[k]);
    }

    // In the cell of these reaches, of e, and in that of twice as many, of |De v| / |v|. |t_1|^a |t_2|^b is at most |t|^n.
    STEP Errors errors_of(const Block (&c)[2], const Block (&reach)[2]) const {
        const auto farthest = [&](double times) {
            const Block x = abs(c[0]) + times * reach[0], y = abs(c[1]) + times * reach[1];
            return SLACK_OF_SUMS * sqrt(x * x + y * y);
        };
        const Block T = farthest(1.0), wide = farthest(2.0);
        Block size = 0.0, slope_size = 0.0;
        for (int n = ORDERS<2>; n > 0; --n) size = (size + sum[n]) * T, slope_size = slope_size * wide + n * sum[n];
        Errors out = {__builtin_inf(), __builtin_inf()};
        for (int k = 0; k < bounds.many; ++k) {
            out.of_value = select(T < Block(bounds.radius[k]), min(out.of_value, bounds.error[k]), out.of_value);
            const auto inside = wide <= Block(WITHIN * bounds.radius[k]);
            out.of_slope = select(inside, min(out.of_slope, slope_error[k]), out.of_slope);
        }
        return {SLACK_OF_SUMS * (out.of_value + ROUNDING_OF_SHIFT * (size + sum[0])),
                SLACK_OF_SUMS * (out.of_slope + ROUNDING_OF_SHIFT * slope_size)};
    }
    enum class Is : char { decided, cut, failed };

    // Adds a zero unless it is a known one. Returns false where that is not certain.
    bool add(const Zero& zero) {
        for (int i = 0; i < out.many; ++i) {
            const Zero& known = out.at[i];
            if (is_within(known.in, zero.alone) || is_within(zero.in, known.alone)) return true;
            if (meets(known.in, zero.alone) || meets(zero.in, known.alone)) return false;
        }
        if (out.many == Zeros::most) return false;
        out.at[out.many++] = zero;
        return true;
    }

    // Cells, and F and M F on them as functions of x and y.
    struct Looked {
        Block error, greatest, M[2][2], w[2], rest[2], off, moved, bends[2];
        Block value[2], slope[2][2], left[2];  // of F at c; left: what F differs by at most from its linear part
        unsigned gone, none;  // whether there is no zero, and |F| exceeds NEARLY_KEPT, or not
    };
    PART void look(const Cell (&cell)[BLOCK], Looked& out) const {
        constexpr int N = ORDERS<2>;
        const Block zero = 0.0;
        Block c[2], h[2], slant, axis;
        for (int l = 0; l < BLOCK; ++l) {
            const Cell& each = cell[l];
            for (int j = 0; j < 2; ++j) c[j].set(l, each.c[j ? 1 - each.axis : each.axis]), h[j].set(l, each.h[j]);
            slant.set(l, each.slant), axis.set(l, each.axis);
        }
        const Block reach[2] = {h[0] + abs(slant) * h[1], h[1]};
        const Errors errors = errors_of(c, reach);
        const Block& error = errors.of_value;
        Block p[2][TERMS<2>], power[TERMS<2>], size[2] = {zero, zero};  // power: h_1^a h_2^b
        power[0] = 1.0;
        for (int n = 1; n <= N; ++n) {
            for (int b = 0; b < n; ++b) power[term_of<2>(n, b)] = power[term_of<2>(n - 1, b)] * h[0];
            power[term_of<2>(n, n)] = power[term_of<2>(n - 1, n - 1)] * h[1];
        }
        const auto swapped = axis > Block(0.5);
        auto gone = zero > zero, none = gone;
        out.error = error, out.greatest = zero;
        for (int o = 0; o < 2; ++o) {
            for (int n = 0; n <= N; ++n) {
                for (int b = 0; b <= n; ++b) {
                    const Block as_it_is = f.value[o][term_of<2>(n, b)], other = f.value[o][term_of<2>(n, n - b)];
                    p[o][term_of<2>(n, b)] = select(swapped, other, as_it_is);
                }
            }
            shift(p[o], c);
            lean(p[o], slant);
            for (int i = 3; i < TERMS<2>; ++i) size[o] += abs(p[o][i]) * power[i];
            out.left[o] = SLACK_OF_SUMS * (size[o] + error + kept);
            size[o] += abs(p[o][1]) * h[0] + abs(p[o][2]) * h[1];
            const Block least = abs(p[o][0]) - SLACK_OF_SUMS * size[o];
            gone = gone | (least > error + kept), none = none | (least > error);
            out.greatest = max(out.greatest, abs(p[o][0]) + size[o]);
            out.value[o] = p[o][0], out.slope[o][0] = p[o][1], out.slope[o][1] = p[o][2];
        }
        const Block over = 1.0 / (p[0][1] * p[1][2] - p[0][2] * p[1][1]);
        // Where there is no inverse, the bounds below are no numbers, or infinite, and decide nothing.
        out.M[0][0] = over * p[1][2], out.M[0][1] = -over * p[0][2], out.M[1][0] = -over * p[1][1], out.M[1][1] = over * p[0][1];
        const Block wider = errors.of_slope * sqrt(reach[0] * reach[0] + reach[1] * reach[1]);
        out.off = out.moved = out.bends[0] = out.bends[1] = zero;
        for (int i = 0; i < 2; ++i) {
            const Block(&M)[2] = out.M[i];
            const Block rows = abs(M[0]) + abs(M[1]), part = 1.0 / h[i];
            // Rounding of M F's terms: of the products with M, whose product with the slopes is one but for its own.
            const Block rounded = 16.0 * UNIT * (abs(M[0]) * (size[0] + abs(p[0][0])) + abs(M[1]) * (size[1] + abs(p[1][0])));
            Block bend = zero, contraction = zero, by[2] = {zero, zero};
            double steep = 2.0;
            for (int n = 2; n <= N; ++n, steep *= 2.0) {
                Block all = zero, second = zero;
                for (int b = 0; b <= n; ++b) {
                    const int term = term_of<2>(n, b);
                    const Block each = abs(M[0] * p[0][term] + M[1] * p[1][term]) * power[term];
                    all += each, second += double(b) * each;
                }
                bend += all, contraction += n * steep * all, by[0] += double(n) * all - second, by[1] += second;
            }
            const Block w = M[0] * p[0][0] + M[1] * p[1][0], known = SLACK_OF_SUMS * (bend + rounded + rows * error);
            out.w[i] = w, out.rest[i] = known + SLACK_OF_SUMS * rows * kept;
            gone = gone | (abs(w) > h[i] + out.rest[i]), none = none | (abs(w) > h[i] + known);
            // Terms of order n in the cell of 2 h: n 2^(n - 1) times as steep as in the cell. Their rounding is so, too.
            out.off = max(SLACK_OF_SUMS * part * (contraction + 200.0 * rounded + rows * wider), out.off);
            out.moved = max(SLACK_OF_SUMS * part * (abs(w) + rounded + rows * error), out.moved);
            for (int j = 0; j < 2; ++j) out.bends[j] += part * by[j];
        }
        out.gone = bits(gone), out.none = bits(none);
    }

    // Decides a cell that was looked at. Where it is cut: `cell` becomes smaller, or along: the number to halve.
    Is decide(const Looked& at, int lane, Cell& cell, int& along) {
        const auto& h = cell.h;
        const bool none = at.none >> lane & 1;
        // Where F' has an inverse all over |F| has no minimum but zero.
        if (at.gone >> lane & 1 || (none && at.off[lane] < 1.0)) return Is::decided;
        const double error = at.error[lane], greatest = at.greatest[lane], bends[2] = {at.bends[0][lane], at.bends[1][lane]};
        const bool nearly = none && greatest <= FLAT_CELL * kept;
        const bool unknown = greatest <= max(2.0 * error, BLURRED * rounding), known = bends[0] + bends[1] < __builtin_inf();
        const double M[2][2] = {{at.M[0][0][lane], at.M[0][1][lane]}, {at.M[1][0][lane], at.M[1][1][lane]}};
        if (known && at.off[lane] <= 0.5 && at.moved[lane] <= 1.0) {
            return refine(cell, M, at.off[lane]) ? Is::decided : Is::failed;
        }
        const double value = max(abs(at.value[0][lane]), abs(at.value[1][lane]));
        if (nearly) return near.add(cell, value) ? Is::decided : Is::failed;
        if (unknown && error <= BLURRED * rounding) return blurred.add(cell, value) ? Is::decided : Is::failed;
        // A smaller cell has the same error.
        if (unknown && max(h[0], h[1]) < 0.1 * max(abs(cell.c[0]), abs(cell.c[1]))) return Is::failed;
        if (!unknown && shrink(at, lane, known, cell)) return along = -1, Is::cut;
        along = (known ? bends[0] > bends[1] : h[0] > h[1]) ? 0 : 1;
        return h[along] < LEAST_PIECE ? Is::failed : Is::cut;
    }
    // To the part where both of M F, or one of F, may be zero. Returns whether much is gone.
    static bool shrink(const Looked& at, int lane, bool known, Cell& cell) {
        const Cell before = cell;
        double least = 0.6 * before.h[0] * before.h[1];
        for (int o = 0; o < 2; ++o) {
            // On the curve F_o = 0 the number that it changes faster with follows from the other.
            const double by_x = at.slope[o][0][lane], by_other = at.slope[o][1][lane] - before.slant * by_x;
            const bool turned = abs(by_other) > abs(by_x);
            const double over = 1.0 / (turned ? by_other : by_x), half = abs(over) * at.left[o][lane];
            const double other = before.reach(turned ? before.axis : 1 - before.axis);
            if (!(half * other < least)) continue;
            least = half * other;
            cell = before;
            cell.axis = turned ? 1 - before.axis : before.axis, cell.slant = -over * (turned ? by_x : by_other);
            cell.h[0] = half + ROUNDED_CELL, cell.h[1] = other + ROUNDED_CELL;
            cell.c[cell.axis] -= over * at.value[o][lane];
        }
        double low[2], high[2];
        // Where much is gone, a zero at the side shall not stay there: the part about it is taken twice as wide, beyond the side,
        // too.
        const bool sharp = max(at.rest[0][lane] / before.h[0], at.rest[1][lane] / before.h[1]) < 0.25;
        for (int i = 0; i < 2; ++i) {
            const double w = at.w[i][lane], rest = at.rest[i][lane];
            low[i] = sharp ? -w - 2.0 * rest : max(-before.h[i], -w - rest);
            high[i] = sharp ? 2.0 * rest - w : min(before.h[i], rest - w);
        }
        const double left = 0.25 * (high[0] - low[0]) * (high[1] - low[1]);
        if (known && left < least) {
            least = left;
            cell = before;
            cell.move(0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]));
            for (int i = 0; i < 2; ++i) cell.h[i] = SLACK_OF_SUMS * 0.5 * (high[i] - low[i]) + ROUNDED_CELL;
        }
        return least < 0.6 * before.h[0] * before.h[1];
    }
    // The only zero in the cell of 2 h, where x, y less M F contracts by a half.
    bool refine(const Cell& cell, const double (&M)[2][2], double off) {
        Cell at = cell;
        double radius = 0.0, w[2], from[2];
        const auto step = [&] {
            double value[2];
            for (int o = 0; o < 2; ++o) {
                value[o] = 0.0;
                for (int b = ORDERS<2>; b >= 0; --b) {
                    double row = 0.0;
                    for (int a = ORDERS<2> - b; a >= 0; --a) row = row * at.c[0] + f.value[o][term_of<2>(a + b, b)];
                    value[o] = value[o] * at.c[1] + row;
                }
            }
            for (int i = 0; i < 2; ++i) w[i] = M[i][0] * value[0] + M[i][1] * value[1];
        };
        for (int round = 0; round < 60; ++round) {
            step();
            at.move(-w[0], -w[1]);
            if (abs(w[0]) < 1e-16 && abs(w[1]) < 1e-16) break;
        }
        step();
        cell.place(at.c, from);
        if (!(abs(from[0]) <= 2.0 * cell.h[0] && abs(from[1]) <= 2.0 * cell.h[1])) return false;
        const double error = errors_of({at.c[0], at.c[1]}, {0.0, 0.0}).of_value[0];
        // In the norm of the contraction.
        for (int i = 0; i < 2; ++i) {
            radius = max(radius, (abs(w[i]) + (abs(M[i][0]) + abs(M[i][1])) * error + 1e-15) / cell.h[i]);
        }
        radius = SLACK_OF_SUMS * radius / (1.0 - off);
        Zero found = {cell, cell, true, {at.c[0], at.c[1]}, 0.0};
        for (int i = 0; i < 2; ++i) found.in.c[i] = at.c[i], found.in.h[i] *= radius, found.alone.h[i] *= 2.0;
        return add(found);
    }

    // All zeros with |t_1|, |t_2| <= out.along, which is from `least` to `along`. The nearest cells come first: what is left
    // undecided ends the square.
    bool divide(double along, double least, double keeps) {
        kept = keeps, whole = along * (1.0 + BAND);
        out.many = blurred.many = near.many = many = 0;
        put({{0.0, 0.0}, {whole, whole}});
        for (int seen = 0; many && whole > least;) {
            Cell now[BLOCK];
            int together = 0;
            while (many && together < BLOCK && waiting[many - 1].nearest() < whole) now[together++] = waiting[--many];
            if (!together) break;
            seen += together;
            if (seen > MOST_CELLS) {
                whole = min(whole, now[0].nearest());
                break;
            }
            for (int l = together; l < BLOCK; ++l) now[l] = now[0];
            Looked at;
            look(now, at);
            for (int l = 0; l < together; ++l) {
                int cut = 0;
                const Is result = decide(at, l, now[l], cut);
                if (result == Is::failed) whole = min(whole, now[l].nearest());
                if (result != Is::cut) continue;
                if (cut < 0) {
                    put(now[l]);
                    continue;
                }
                now[l].h[cut] *= 0.5;
                for (double& h : now[l].h) h += ROUNDED_CELL;
                for (int side = -1; side <= 1; side += 2) {
                    Cell half = now[l];
                    half.move(cut ? 0.0 : side * half.h[0], cut ? side * half.h[1] : 0.0);
                    put(half);
                }
            }
        }
        if (!(whole > least)) return false;
        for (int i = 0; i < blurred.many; ++i) {
            for (int k = 0; k < out.many; ++k) {
                if (meets(out.at[k].in, blurred.at[i].in)) return false;
            }
        }
        const auto add_all = [&](const Joined& from) {
            for (int i = 0; i < from.many; ++i) {
                if (out.many == Zeros::most) return false;
                out.at[out.many++] = from.at[i];
            }
            return true;
        };
        if (!add_all(blurred)) return false;
        // Beside a zero these stand for nothing of their own.
        if (!out.many && !add_all(near)) return false;
        // The largest square with nothing near its side.
        for (out.along = whole / (1.0 + BAND); out.along > least; out.along *= 1.0 - BAND) {
            const double inside = out.along * (1.0 - BAND), outside = out.along * (1.0 + 0.5 * BAND);
            bool clear = true;
            for (int i = 0; i < out.many; ++i) {
                const Cell& in = out.at[i].in;
                clear = clear && (!out.at[i].single || is_within(in, square_of(inside)) || !meets(in, square_of(outside)));
            }
            if (!clear) continue;
            int kept = 0;
            for (int i = 0; i < out.many; ++i) {
                Zero each = out.at[i];
                if (!meets(each.in, square_of(each.single ? inside : out.along))) continue;
                // What stands for an area that crosses the side lies inside.
                each.crosses = !each.single && !is_within(each.in, square_of(out.along));
                for (double& t : each.t) t = max(-inside, min(inside, t));
                out.at[kept++] = each;
            }
            out.many = kept;
            return true;
        }
        return false;
    }
    // A cell that waits, by its distance: the farthest first. Where there is no room, the farthest one ends the square.
    void put(const Cell& cell) {
        const double far = cell.nearest();
        if (!(far < whole)) return;
        if (many == MOST_WAITING) {
            whole = min(whole, max(far, waiting[0].nearest()));
            if (!(far < whole)) return;
            for (int i = 1; i < many; ++i) waiting[i - 1] = waiting[i];
            --many;
        }
        int i = many++;
        for (; i > 0 && waiting[i - 1].nearest() < far; --i) waiting[i] = waiting[i - 1];
        waiting[i] = cell;
    }
};

// All zeros of F in a square about t = 0 that is as large as can be, at least `least`. Returns whether there is one.
PART bool zeros_on_surface(const OnSurface& f, const Reduced& bounds, double rounding, double least, Zeros& out) {
    SurfaceDivider divider(f, bounds, rounding, out);
    return divider.divide(0.6 * bounds.along, least, 0.0) && (out.many || divider.divide(out.along, least, NEARLY_KEPT));
}

}  // namespace urdf_ik::URDF_IK_LEVEL
