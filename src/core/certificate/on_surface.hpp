// The real solutions on a piece of a surface, where two ranks are all but lost, as the zeros of two functions of two numbers.
//
// With t = (t_1, t_2) in the directions of the two smallest singular values, and Y(t) the surface of valley.hpp on which f's first
// four outputs vanish up to a high order, the solutions near the surface are the zeros of F(t) = P(t) + e(t), with bounds on e for
// complex |t| <= R as in along_valley.hpp. On each complex line through t Cauchy's formula bounds the derivatives,
// |De(t) v| <= |v| max |e| / (R - |t|).
//
// A cell |t_i - c_i| <= h_i is cut in two until
//   F has no zero: one of its values exceeds its error, or one of those of M F, M an inverse of F' at c
//   M F' is within 1/2 of 1 in the cell of 2 h, in the norm max |t_i| / h_i. Then t - M F contracts it by 1/2, and it has at most
//     one zero: none in the cell if |M F(c)| > 3/2, and one in that of 2 h if |M F(c)| <= 1
//   F is rounding in all of it. Such cells that touch hold joint vectors that one stands for, if it keeps the pose
// No zero and no cell of the last kind may lie near the side of the whole, nor may a zero meet such a cell. A zero of M F lies
// where its linear part is as small as the rest may be: a cell is first cut to that.
#pragma once

#include "certificate/along_valley.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

using OnSurface = Left<2>;

// Bounds on e and on |De v| / |v| in a cell.
struct Errors {
    Block of_value, of_slope;
};
// P's terms about c.
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

// Cells that are looked at and that may wait in all, failed ones in a square, and areas that stand for others. They decide the cost
// only. At round poses of ten rounded arms 800 cells left 7.2 % of the poses open where 400 left 7.3 %.
inline constexpr int MOST_CELLS = 400, MOST_WAITING = 150, MOST_FAILED = 8, MOST_JOINED = 16;
// Zeros keep this share of the whole width from its sides.
inline constexpr double BAND = 0.05;
// A cell's sides have at least this ratio: where F' has all but no inverse the shorter one tells nothing. It decides the cost only.
inline constexpr double LEAST_ASPECT = 2e-3;
// Where errors of slopes are taken from a radius.
inline constexpr double WITHIN = 0.75;
// A cell without a zero is as small as need be where |F| is at most so many times what counts as zero.
inline constexpr double FLAT_CELL = 8.0;

// A zero of F, the only one within `alone` of c, which holds [low, high]; or an area that one joint vector stands for.
struct Zero {
    double low[2], high[2], c[2], alone[2];
    bool single;
    STEP double t(int i) const { return 0.5 * (low[i] + high[i]); }
    // Whether t is this one, if F is zero there.
    STEP bool holds(const double (&t)[2]) const { return abs(t[0] - c[0]) <= alone[0] && abs(t[1] - c[1]) <= alone[1]; }
};
struct Zeros {
    static constexpr int most = 16;
    Zero at[most];
    int many = 0;
    double along;  // these are all with |t_1|, |t_2| <= along
};
// Whether [low, high] of a meets, or lies within, the cell about c.
STEP bool meets(const Zero& a, const double (&c)[2], const double (&h)[2]) {
    return a.high[0] >= c[0] - h[0] && a.low[0] <= c[0] + h[0] && a.high[1] >= c[1] - h[1] && a.low[1] <= c[1] + h[1];
}
STEP bool is_within(const Zero& a, const double (&c)[2], const double (&h)[2]) {
    return a.low[0] >= c[0] - h[0] && a.high[0] <= c[0] + h[0] && a.low[1] >= c[1] - h[1] && a.high[1] <= c[1] + h[1];
}

struct Cell {
    double c[2], h[2];
};
// Cells; those that touch are one.
struct Joined {
    Zero at[MOST_JOINED];
    int many = 0;

    // Returns whether there is room.
    bool add(const Cell& cell) {
        const auto &c = cell.c, &h = cell.h;
        Zero all = {{c[0] - h[0], c[1] - h[1]}, {c[0] + h[0], c[1] + h[1]}, {c[0], c[1]}, {h[0], h[1]}, false};
        for (int k = 0; k < many;) {
            const Zero& each = at[k];
            const double gap[2] = {all.alone[0] + LEAST_PIECE, all.alone[1] + LEAST_PIECE};
            if (!meets(each, all.c, gap)) {
                ++k;
                continue;
            }
            for (int j = 0; j < 2; ++j) {
                all.low[j] = min(all.low[j], each.low[j]), all.high[j] = max(all.high[j], each.high[j]), all.c[j] = all.t(j);
                all.alone[j] = 0.5 * (all.high[j] - all.low[j]);
            }
            // The grown one may touch others.
            at[k] = at[--many], k = 0;
        }
        if (many == MOST_JOINED) return false;
        at[many++] = all;
        return true;
    }
};

struct SurfaceDivider {
    const OnSurface& f;
    const Reduced& bounds;
    double rounding;
    Zeros& out;
    Joined blurred, near;  // where F is rounding; without a zero where a joint vector may keep the pose to NEARLY_KEPT
    int seen = 0;  // cells
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

    // In the cell, of e, and in that of 2 h, of |De v| / |v|. |t_1|^a |t_2|^b is at most |t|^n.
    STEP Errors errors_of(const Block (&c)[2], const Block (&h)[2]) const {
        const auto farthest = [&](double times) {
            const Block x = abs(c[0]) + times * h[0], y = abs(c[1]) + times * h[1];
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
            if (is_within(known, zero.c, zero.alone) || is_within(zero, known.c, known.alone)) return true;
            if (meets(known, zero.c, zero.alone) || meets(zero, known.c, known.alone)) return false;
        }
        if (out.many == Zeros::most) return false;
        out.at[out.many++] = zero;
        return true;
    }

    // F and M F on a block of cells.
    struct Looked {
        Block error, greatest, M[2][2], w[2], rest[2], off, moved, bends[2];
        unsigned gone, none;  // whether there is no zero, and |F| exceeds NEARLY_KEPT, or not
    };
    PART void look(const Block (&c)[2], const Block (&h)[2], Looked& out) const {
        constexpr int N = ORDERS<2>;
        const Block zero = 0.0;
        const Errors errors = errors_of(c, h);
        const Block& error = errors.of_value;
        Block p[2][TERMS<2>], power[TERMS<2>], size[2] = {zero, zero};  // power: h_1^a h_2^b
        power[0] = 1.0;
        for (int n = 1; n <= N; ++n) {
            for (int b = 0; b < n; ++b) power[term_of<2>(n, b)] = power[term_of<2>(n - 1, b)] * h[0];
            power[term_of<2>(n, n)] = power[term_of<2>(n - 1, n - 1)] * h[1];
        }
        auto gone = zero > zero, none = gone;
        out.error = error, out.greatest = zero;
        for (int o = 0; o < 2; ++o) {
            for (int i = 0; i < TERMS<2>; ++i) p[o][i] = f.value[o][i];
            shift(p[o], c);
            for (int i = 1; i < TERMS<2>; ++i) size[o] += abs(p[o][i]) * power[i];
            const Block least = abs(p[o][0]) - SLACK_OF_SUMS * size[o];
            gone = gone | (least > error + kept), none = none | (least > error);
            out.greatest = max(out.greatest, abs(p[o][0]) + size[o]);
        }
        const Block over = 1.0 / (p[0][1] * p[1][2] - p[0][2] * p[1][1]);
        // Where there is no inverse, the bounds below are no numbers, or infinite, and decide nothing.
        out.M[0][0] = over * p[1][2], out.M[0][1] = -over * p[0][2], out.M[1][0] = -over * p[1][1], out.M[1][1] = over * p[0][1];
        const Block wider = errors.of_slope * sqrt(h[0] * h[0] + h[1] * h[1]);
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
        const auto &c = cell.c, &h = cell.h;
        const bool none = at.none >> lane & 1;
        // Where F' has an inverse all over |F| has no minimum but zero.
        if (at.gone >> lane & 1 || (none && at.off[lane] < 1.0)) return Is::decided;
        const double error = at.error[lane], greatest = at.greatest[lane], bends[2] = {at.bends[0][lane], at.bends[1][lane]};
        const bool nearly = none && greatest <= FLAT_CELL * kept;
        const bool unknown = greatest <= max(2.0 * error, BLURRED * rounding);
        along = h[0] > h[1] ? 0 : 1;
        if (bends[0] + bends[1] < __builtin_inf()) {
            const double M[2][2] = {{at.M[0][0][lane], at.M[0][1][lane]}, {at.M[1][0][lane], at.M[1][1][lane]}};
            if (at.off[lane] <= 0.5 && at.moved[lane] <= 1.0) return refine(cell, M, at.off[lane]) ? Is::decided : Is::failed;
            along = bends[0] > bends[1] ? 0 : 1;
            if (h[along] < LEAST_ASPECT * h[1 - along]) along = 1 - along;
            const double w[2] = {at.w[0][lane], at.w[1][lane]}, rest[2] = {at.rest[0][lane], at.rest[1][lane]};
            if (!nearly && !unknown && cut_to(cell, w, rest)) return along = -1, Is::cut;
        }
        if (nearly) return near.add(cell) ? Is::decided : Is::failed;
        if (unknown && error <= BLURRED * rounding) return blurred.add(cell) ? Is::decided : Is::failed;
        // A smaller cell has the same error.
        if (unknown && max(h[0], h[1]) < 0.1 * max(abs(c[0]), abs(c[1]))) return Is::failed;
        return h[along] < LEAST_PIECE ? Is::failed : Is::cut;
    }
    // To |t_i - c_i + w_i| <= rest_i. Returns whether much is gone.
    static bool cut_to(Cell& cell, const double (&w)[2], const double (&rest)[2]) {
        bool much = false;
        for (int i = 0; i < 2; ++i) {
            const double low = max(-cell.h[i], -w[i] - rest[i]), high = min(cell.h[i], rest[i] - w[i]), half = 0.5 * (high - low);
            if (!(half < 0.6 * cell.h[i])) continue;
            much = true;
            cell.c[i] += 0.5 * (low + high), cell.h[i] = SLACK_OF_SUMS * half + 1e-16;
        }
        return much;
    }
    // The only zero in the cell of 2 h, where t - M F contracts by a half.
    bool refine(const Cell& cell, const double (&M)[2][2], double off) {
        double t[2] = {cell.c[0], cell.c[1]}, radius = 0.0, w[2];
        const auto step = [&] {
            double value[2];
            for (int o = 0; o < 2; ++o) {
                value[o] = 0.0;
                for (int b = ORDERS<2>; b >= 0; --b) {
                    double row = 0.0;
                    for (int a = ORDERS<2> - b; a >= 0; --a) row = row * t[0] + f.value[o][term_of<2>(a + b, b)];
                    value[o] = value[o] * t[1] + row;
                }
            }
            for (int i = 0; i < 2; ++i) w[i] = M[i][0] * value[0] + M[i][1] * value[1];
        };
        for (int round = 0; round < 60; ++round) {
            step();
            t[0] -= w[0], t[1] -= w[1];
            if (abs(w[0]) < 1e-16 && abs(w[1]) < 1e-16) break;
        }
        step();
        if (!(abs(t[0] - cell.c[0]) <= 2.0 * cell.h[0] && abs(t[1] - cell.c[1]) <= 2.0 * cell.h[1])) return false;
        const double error = errors_of({t[0], t[1]}, {0.0, 0.0}).of_value[0];
        // In the norm of the contraction.
        for (int i = 0; i < 2; ++i) {
            radius = max(radius, (abs(w[i]) + (abs(M[i][0]) + abs(M[i][1])) * error + 1e-15) / cell.h[i]);
        }
        radius = SLACK_OF_SUMS * radius / (1.0 - off);
        const double r[2] = {radius * cell.h[0], radius * cell.h[1]};
        return add({{t[0] - r[0], t[1] - r[1]},
                    {t[0] + r[0], t[1] + r[1]},
                    {cell.c[0], cell.c[1]},
                    {2.0 * cell.h[0], 2.0 * cell.h[1]},
                    true});
    }

    // All zeros with |t_1|, |t_2| <= out.along, which is from `least` to `along`.
    bool divide(double along, double least, double keeps) {
        kept = keeps;
        out.many = blurred.many = near.many = 0;
        Cell waiting[MOST_WAITING + 2 * BLOCK];
        double whole = along * (1.0 + BAND);
        int failed = 0;
        waiting[0] = {{0.0, 0.0}, {whole, whole}};
        for (int many = 1; many;) {
            Cell now[BLOCK];
            int together = 0;
            while (many && together < BLOCK) {
                now[together] = waiting[--many];
                together += nearest_of(now[together]) < whole;
            }
            if (!together) break;
            if (seen + together > MOST_CELLS) return false;
            seen += together;
            Block c[2], h[2];
            for (int l = 0; l < BLOCK; ++l) {
                for (int j = 0; j < 2; ++j) {
                    c[j].set(l, now[l < together ? l : 0].c[j]), h[j].set(l, now[l < together ? l : 0].h[j]);
                }
            }
            Looked at;
            look(c, h, at);
            for (int l = 0; l < together; ++l) {
                int cut = 0;
                const Is result = decide(at, l, now[l], cut);
                if (many > MOST_WAITING) return false;
                if (result == Is::failed) {
                    whole = min(whole, nearest_of(now[l]));
                    if (!(whole > least) || ++failed > MOST_FAILED) return false;
                    continue;
                }
                if (result == Is::decided) continue;
                if (cut < 0) {
                    waiting[many++] = now[l];
                    continue;
                }
                now[l].h[cut] *= 0.5;
                for (int side = -1; side <= 1; side += 2) {
                    waiting[many] = now[l], waiting[many++].c[cut] += side * now[l].h[cut];
                }
            }
        }
        for (int i = 0; i < blurred.many; ++i) {
            for (int k = 0; k < out.many; ++k) {
                if (meets(out.at[k], blurred.at[i].c, blurred.at[i].alone)) return false;
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
        const double zero[2] = {0.0, 0.0};
        for (out.along = whole / (1.0 + BAND); out.along > least; out.along *= 1.0 - BAND) {
            const double inside = out.along * (1.0 - BAND), outside = out.along * (1.0 + 0.5 * BAND);
            bool clear = true;
            for (int i = 0; i < out.many; ++i) {
                clear = clear && (is_within(out.at[i], zero, {inside, inside}) || !meets(out.at[i], zero, {outside, outside}));
            }
            if (!clear) continue;
            int kept = 0;
            for (int i = 0; i < out.many; ++i) {
                if (meets(out.at[i], zero, {inside, inside})) out.at[kept++] = out.at[i];
            }
            out.many = kept;
            return true;
        }
        return false;
    }
    // Squares about 0 up to this do not meet a cell.
    static double nearest_of(const Cell& cell) { return max(abs(cell.c[0]) - cell.h[0], abs(cell.c[1]) - cell.h[1]); }
};

// All zeros of F in a square about t = 0 that is as large as can be, at least `least`. Returns whether there is one.
PART bool zeros_on_surface(const OnSurface& f, const Reduced& bounds, double rounding, double least, Zeros& out) {
    SurfaceDivider divider(f, bounds, rounding, out);
    for (double along = 0.6 * bounds.along; along > least && divider.seen < MOST_CELLS; along *= 0.5) {
        if (divider.divide(along, least, 0.0) && (out.many || divider.divide(out.along, least, NEARLY_KEPT))) return true;
    }
    return false;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
