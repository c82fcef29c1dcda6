// The real solutions along a piece of a valley (valley.hpp), counted as the zeros of one function of one number.
//
// Let d = V (Y(t) + y, t), with Y the curve, and g' and g_t f's first five outputs and its last one. For |t| <= R and |y| = across,
// t and y complex, A_yy y exceeds whatever else g' consists of:
//   (s' - |H'_ty| R - |H'_yy| |Y|) across > b + |H'_yy| across^2 / 2 + h(across),  h(x) = s x (s_t R + s |Y| + s x)^2 e^0.3 / 2,
//   b >= |g'| on the curve: f's rounding, the series' coefficients, and what is beyond their order,
// with the norms of cluster.hpp, where h is derived. By Rouche's theorem g'(t, .) has exactly one zero y(t) with |y| <= across for
// each such t, a simple one, so y(t) is analytic there, and real for real t. By the same inequality |y(t)| is at most
// rho = (b + |H'_yy| x^2 / 2 + h(x)) / (s' - ...) for each x that bounds it. So the solutions within `across` of the curve, with t
// in [-R, R], are exactly the zeros of F(t) = g_t(t, y(t)), and F is the curve's series p up to an analytic e(t) with
//   |e| <= (|A_ty| + |H_t,ty| R + |H_t,yy| |Y|) rho + |H_t,yy| rho^2 / 2 + h(rho)    what y(t) adds to g_t
//          + what is beyond the series, and the rounding of f and of its coefficients    for complex |t| <= R,
// and by Cauchy's formula |e'(t)| <= max |e| / (R - |t|). Both bounds are computed for several R; a smaller |t| takes the least.
//
// [low, high] is cut until on each piece |F| exceeds NEARLY_KEPT, or F' does not vanish, or neither can be told. Between points
// with |F| > 0 for certain F has, where it is monotone, one zero if its signs differ, else none: any number of zeros is counted.
// Where neither can be told |F| is rounding, and so is the pose's error at each point: such a stretch of joint vectors has one that
// stands for all, as has a minimum of |F| of at most NEARLY_KEPT. The piece of the valley ends where |F| exceeds rounding by far,
// so that a root that is known up to rounding is either in it or not.
#pragma once

#include "certificate/cluster.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A root this near to an end of a piece [rad] may lie on either side of it.
inline constexpr double AT_AN_END = 1e-5;
// Boxes for which a piece is looked for are narrower than this [rad]; a piece that is wider is not better, one that is longer is.
inline constexpr double WIDE_ENOUGH = 0.01;
// Radii, each this share of the one before; they decide how tight the bounds are.
inline constexpr double NEXT_RADIUS = 0.75;
// The largest surface [rad]: where it isn't, LARGEST_BALL ends it.
inline constexpr double LARGEST_SURFACE = 0.15;
// Pieces that are looked at, and the least half width [rad] of one; they decide the cost only.
inline constexpr int MOST_PIECES = 320;
inline constexpr double LEAST_PIECE = 1e-9;
// Shifting a polynomial of degree HIGHEST takes up to HIGHEST products and sums in turn for each coefficient.
inline constexpr double ROUNDING_OF_SHIFT = 40.0 * UNIT;

// F = p + e, with |e| <= error[k] for complex |t| <= radius[k]; radii fall.
struct Reduced {
    static constexpr int most = 24;
    double radius[most], error[most];
    int many = 0;
    double across, along;  // the solutions that are counted: within `across` of the curve, for |t| <= along
};

// Returns whether there is a piece.
template <int r> PART bool reduce(const Local& at, const Norms& norms, const Left<r>& valley, Reduced& out) {
    if (!at.near) return false;
    double f_y = 0.0;
    for (int o = 0; o < 6 - r; ++o) f_y += square(at.g[o]);
    f_y = sqrt(f_y) + at.rounding;
    const auto& [least, A_ty, y_ty, y_yy, t_ty, t_yy, s_t] = norms;
    const double s = at.spread;
    double R = r == 1 ? LARGEST_CLUSTER : LARGEST_SURFACE, best = 0.0;
    out.many = 0;
    for (int k = 0; k < Reduced::most; ++k, R *= NEXT_RADIUS) {
        const double height = valley.height(R), a = s_t * R + s * height, slope = least - y_ty * R - y_yy * height;
        if (!(a < LARGEST_BALL) || !(slope > 0.0)) continue;
        const double beyond = valley.beyond(R);
        double base = f_y + beyond, rounding = at.rounding, power = 1.0;
        for (int n = 1; n <= ORDERS<r>; ++n) {
            power *= R;
            base += valley.y[n] * power, rounding += 0.5 * (valley.t[n] - valley.least[n]) * power;
        }
        const auto higher = [&](double x) { return 0.5 * GROWTH * s * x * square(a + s * x); };
        const auto rest = [&, y_yy = y_yy](double x) { return SLACK_OF_SUMS * (base + 0.5 * y_yy * x * x + higher(x)); };
        const auto one_within = [&](double x) { return a + s * x < LARGEST_BALL && slope * x > rest(x); };
        // Any value may be tried: twice what the terms in t alone ask for.
        double rho = 2.0 * base / slope;
        if (!one_within(rho)) continue;
        // The widest within which there is no other: by halving, since the condition is convex.
        double across = rho, wide = LARGEST_CLUSTER;
        for (int halving = 0; halving < 6; ++halving) {
            const double between = sqrt(across * wide);
            (one_within(between) ? across : wide) = between;
        }
        // Far wider than where the solutions are: one that is known up to rounding is not at the side.
        if (!(across > 4.0 * rho)) continue;
        for (int round = 0; round < 2; ++round) rho = min(rho, rest(rho) / slope);
        out.radius[out.many] = R;
        out.error[out.many++] =
            SLACK_OF_SUMS * ((A_ty + t_ty * R + t_yy * height) * rho + 0.5 * t_yy * rho * rho + higher(rho) + beyond + rounding);
        // The largest radius has no derivative.
        const double of_use = R * min(across, WIDE_ENOUGH);
        if (out.many > 1 && of_use > best) best = of_use, out.across = across, out.along = R;
    }
    return best > 0.0;
}

// What is known on a piece of [low, high].
enum class On : char {
    away,  // |F| > NEARLY_KEPT
    slope,  // F' has no zero
    near,  // F has no zero, but is below NEARLY_KEPT
    blurred,  // |F| is rounding
    open  // nothing: the bounds are too wide
};
struct Piece {
    double low, high;
    On what;
};

// What was found: a zero of F, the only one in [low, high], or joint vectors in [low, high] that one stands for.
struct Crossing {
    double low, high, t;
    bool single;
};
struct Crossings {
    static constexpr int most = 16;
    Crossing at[most];
    int many = 0;
    double low, high;  // these are all with t in [low, high]
};

// F on a piece: p's coefficients about its middle, and the bounds on e and e' there.
struct OnPiece {
    double c[HIGHEST + 1], error, slope_error;
    double least, greatest, least_slope, greatest_slope;  // of |p|, |p'|
};
STEP OnPiece on_piece(const Valley& valley, const Reduced& bounds, double low, double high) {
    OnPiece out;
    const double m = 0.5 * (low + high), h = 0.5 * (high - low), T = max(abs(low), abs(high));
    double size = 0.0, slope_size = 0.0;
    for (int n = HIGHEST; n >= 0; --n) {
        out.c[n] = valley.value[0][n];
        slope_size = slope_size * T + size, size = size * T + abs(valley.value[0][n]);
    }
    for (int i = 0; i < HIGHEST; ++i) {
        for (int j = HIGHEST - 1; j >= i; --j) out.c[j] += m * out.c[j + 1];
    }
    double rest = 0.0, slope_rest = 0.0;
    for (int n = HIGHEST; n > 1; --n) rest = (rest + abs(out.c[n])) * h, slope_rest = (slope_rest + n * abs(out.c[n])) * h;
    rest = (rest + abs(out.c[1])) * h;
    out.least = abs(out.c[0]) - rest, out.greatest = abs(out.c[0]) + rest;
    out.least_slope = abs(out.c[1]) - slope_rest, out.greatest_slope = abs(out.c[1]) + slope_rest;
    out.error = out.slope_error = __builtin_inf();
    for (int k = 0; k < bounds.many; ++k) {
        if (bounds.radius[k] >= T) out.error = min(out.error, bounds.error[k]);
        if (bounds.radius[k] > T) out.slope_error = min(out.slope_error, bounds.error[k] / (bounds.radius[k] - T));
    }
    out.error = SLACK_OF_SUMS * (out.error + ROUNDING_OF_SHIFT * size);
    out.slope_error = SLACK_OF_SUMS * (out.slope_error + ROUNDING_OF_SHIFT * slope_size);
    return out;
}

// The pieces of [-along, along] in order. Returns their number, 0 if there are too many.
PART int pieces_of(const Valley& valley, const Reduced& bounds, double rounding, Piece (&piece)[MOST_PIECES]) {
    double high[64], low = -bounds.along;
    int waiting = 0, many = 0;
    const double start[4] = {1.0, 0.25, 0.0, -0.25};
    for (const double each : start) high[waiting++] = each * bounds.along;
    for (int seen = 0; waiting && seen < 2 * MOST_PIECES; ++seen) {
        const double end = high[waiting - 1], middle = 0.5 * (low + end);
        const OnPiece on = on_piece(valley, bounds, low, end);
        On what = On::open;
        // Twice the bounds: a piece is not cut to follow where they are met exactly.
        const bool flat = on.greatest_slope <= 2.0 * on.slope_error || end - low < 2.0 * LEAST_PIECE;
        if (on.least > on.error + NEARLY_KEPT) what = On::away;
        else if (on.least_slope > on.slope_error) what = On::slope;
        else if (flat && on.least > on.error) what = On::near;
        else if (flat && (on.greatest <= 2.0 * on.error || end - low < 2.0 * LEAST_PIECE)) {
            if (on.error <= BLURRED * rounding) what = On::blurred;
        } else if (waiting < 64) {
            high[waiting++] = middle;
            continue;
        }
        if (many == MOST_PIECES) return 0;
        piece[many++] = {low, end, what};
        low = end, --waiting;
    }
    return waiting ? 0 : many;
}

// The sign of F at t: 0 where |p| is at most its error.
STEP int sign_at(const Valley& valley, const Reduced& bounds, double t) {
    const OnPiece on = on_piece(valley, bounds, t, t);
    return !(on.least > on.error) ? 0 : on.c[0] > 0.0 ? 1 : -1;
}
// The sign of F' on a piece where it has no zero.
STEP int direction_of(const Valley& valley, const Piece& piece) {
    double slope;
    valley.output(0.5 * (piece.low + piece.high), slope);
    return slope > 0.0 ? 1 : -1;
}
// Where p, or its derivative, changes its sign in [low, high]: by halving.
PART double zero_between(const Valley& valley, double low, double high, bool derivative) {
    const auto at = [&](double t) {
        double slope;
        const double value = valley.output(t, slope);
        return derivative ? slope : value;
    };
    const bool rises = at(high) > at(low);
    for (int k = 0; k < 50; ++k) {
        const double middle = 0.5 * (low + high);
        ((at(middle) > 0.0) == rises ? high : low) = middle;
    }
    return 0.5 * (low + high);
}

// All zeros of F in a piece of the valley about t = 0 that is as long as can be. Returns whether there is one.
PART bool crossings_of(const Valley& valley, const Reduced& bounds, double rounding, Crossings& out) {
    Piece piece[MOST_PIECES];
    const int many = pieces_of(valley, bounds, rounding, piece);
    int first = 0, last = -1;
    for (int i = 0; i < many; ++i) {
        if (piece[i].low <= 0.0 && piece[i].high >= 0.0) first = i, last = i;
    }
    if (last < 0 || piece[first].what == On::open) return false;
    while (first > 0 && piece[first - 1].what != On::open) --first;
    while (last + 1 < many && piece[last + 1].what != On::open) ++last;
    // Roots, stretches of rounding and minima of |F| that are known up to rounding do not lie at an end.
    const auto is_end = [&](On what, double t) {
        const OnPiece on = on_piece(valley, bounds, t - AT_AN_END, t + AT_AN_END);
        return (what == On::away || what == On::slope) && on.least > on.error + 2.0 * BLURRED * rounding &&
               (on.least > on.error + 2.0 * NEARLY_KEPT || on.least_slope > on.slope_error);
    };
    while (first <= last && !is_end(piece[first].what, piece[first].low)) ++first;
    while (first <= last && !is_end(piece[last].what, piece[last].high)) --last;
    if (first > last || piece[first].low > 0.0 || piece[last].high < 0.0) return false;
    out.low = piece[first].low, out.high = piece[last].high, out.many = 0;
    const auto add = [&](double low, double high, bool crosses, bool single) {
        if (out.many == Crossings::most) return false;
        out.at[out.many++] = {low, high, zero_between(valley, low, high, !crosses), single};
        return true;
    };
    int sign = sign_at(valley, bounds, out.low);
    for (int i = first; i <= last;) {
        const double low = piece[i].low;
        int j = i;
        if (piece[i].what == On::away) {
            ++i, sign = sign_at(valley, bounds, piece[j].high);
            continue;
        }
        if (piece[i].what == On::near) {
            while (piece[j].what == On::near) ++j;
            // A minimum of |F|, unless |F| rises into the stretch, or falls behind it. A stretch of rounding beside it stands for
            // it.
            const auto is_no_minimum = [&](const Piece& beside, int outwards) {
                return beside.what == On::blurred ||
                       (beside.what == On::slope && direction_of(valley, beside) * sign * outwards < 0);
            };
            const double high = piece[j - 1].high;
            if (!is_no_minimum(piece[i - 1], -1) && !is_no_minimum(piece[j], 1) && !add(low, high, false, false)) return false;
            i = j, sign = sign_at(valley, bounds, high);
            continue;
        }
        bool monotone = true;
        int next = 0;
        while (j <= last && (piece[j].what == On::slope || piece[j].what == On::blurred)) {
            monotone = monotone && piece[j].what == On::slope;
            next = sign_at(valley, bounds, piece[j++].high);
            if (next) break;
        }
        const double high = piece[j - 1].high;
        if (!sign || !next) return false;
        if (!monotone || next != sign) {
            if (!add(low, high, next != sign, monotone)) return false;
        }
        i = j, sign = next;
    }
    return true;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
