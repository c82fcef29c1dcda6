// A bound on the number of zeros of a trigonometric polynomial of degree eight on the circle, each coefficient of which is known up
// to an error.
//
// On an arc theta = centre + 2 atan(t), |t| <= tau = tan(half / 2), the polynomial sum_k c_k e^(i k theta) times (1 + t^2)^8 is
//   sum_k c_k e^(i k centre) (1 + i t)^(8 + k) (1 - i t)^(8 - k),
// a real polynomial in t of degree 16. Its Bernstein coefficients on the arc are its polar form at -tau and tau, which is for each
// term the mean of products of sixteen factors 1 +- i tau: an error of at most e in every c_k changes a coefficient by at most
// 17 e (1 + tau^2)^8. By Descartes' rule of signs (Lane and Riesenfeld 1981) there are at most as many zeros, by multiplicity, as
// the coefficients change their sign. An arc with more changes than zeros are known there is cut in two.
#pragma once

#include "certify/single.hpp"
#include "numbers/doubled.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A real trigonometric polynomial: c_k for k >= 0, the others are conjugates. error: of each of them. S: double or Doubled.
template <class S> struct OnCircle {
    static constexpr int degree = 8;
    S re[degree + 1], im[degree + 1];
    double error;
};

// The coefficients of (1 + x)^i (1 - x)^(16 - i), and one over the binomials of 16, with what their rounding leaves out.
struct Krawtchouk {
    static constexpr int n = 2 * OnCircle<double>::degree;
    double at[n + 1][n + 1] = {}, over_binomial[n + 1] = {}, rest[n + 1] = {};
    constexpr Krawtchouk() {
        for (int i = 0; i <= n; ++i) {
            at[i][0] = 1.0;
            for (int k = 0; k < n; ++k) {
                const double sign = k < i ? 1.0 : -1.0;
                for (int j = k + 1; j > 0; --j) at[i][j] += sign * at[i][j - 1];
            }
        }
        for (int j = 0; j <= n; ++j) {
            const double binomial = at[n][j], over = 1.0 / binomial, half = float(over);
            over_binomial[j] = over, rest[j] = ((1.0 - half * binomial) - (over - half) * binomial) / binomial;
        }
    }
};
inline constexpr Krawtchouk KRAWTCHOUK;

// Arcs that are looked at before the number of zeros is left open; it decides the cost only.
inline constexpr int MOST_ARCS = 160;
// Arcs start no wider than this [rad], so that powers of 1 + tau do not lose digits.
inline constexpr double WIDEST_ARC = 0.6;
// Arcs overlap by this [rad], and end no narrower. Descartes' rule counts the zeros in Obreshkoff's lens about the arc, which meets
// the arc's ends under an angle of pi / 18: all zeros within 8 % of this from the circle are counted, as a change of the pose by
// its tolerance may bring them onto it.
inline constexpr double OVERLAP = 3e-4;
// An arc is cut beside the middle of its widest gap without a known zero: in the middle itself may be another one.
inline constexpr double CUT = 0.07;
// Known zeros nearer than this [rad] are looked at together first.
inline constexpr double TOGETHER = 0.1;
// Eight products of turns, then sums of nine and of 17 products with powers of tau: less than 160 units.
inline constexpr double ROUNDING_OF_BERNSTEIN = 160.0;

// What the arcs' polynomials are computed in, by what the coefficients are: the unit, the turn to an angle, a constant.
template <class S> struct OnArcs {
    using Number = Block;
    static constexpr double unit = UNIT;
    static STEP Turn<Block> turn_to(const Block& angle) { return cos_sin(angle); }
    static STEP double number(double a, double) { return a; }
    static STEP Block number(const Block& a) { return a; }
};
template <> struct OnArcs<Doubled> {
    using Number = DoubledOf<Block>;
    static constexpr double unit = DOUBLED_UNIT;
    // The angle is moved by rounding of the cosine and the sine: |(c, s)| = sqrt(1 + d) is divided out to d^2.
    static STEP Turn<Number> turn_to(const Block& angle) {
        const Turn<Block> t = cos_sin(angle);
        const Number c = {t.c, Block(0.0)}, s = {t.s, Block(0.0)}, over = 1.5 - 0.5 * (c * c + s * s);
        return {over * c, over * s};
    }
    static STEP Doubled number(double a, double rest) { return {a, rest}; }
    static STEP Number number(const Block& a) { return {a, Block(0.0)}; }
};

// Bounds on the numbers of zeros in a block of arcs [rad].
template <class S> PART Block zeros_on(const OnCircle<S>& p, const Block& centre, const Block& half) {
    using On = OnArcs<S>;
    using V = typename On::Number;
    constexpr int n = Krawtchouk::n;
    const Turn<V> turn = On::turn_to(centre);
    // tan(x) <= x + 0.4 x^3 for x <= 0.5, and the arc's ends are rounded outwards.
    const Block h = 0.5 * (half + 4e-15 * (1.0 + abs(centre))), tau = h + 0.4 * h * h * h;
    V m[n + 1], b[n + 1];
    Block size = abs(leading(p.re[0]));
    Turn<V> power = {1.0, 0.0};
    for (int j = 0; j <= n; ++j) {
        m[j] = 0.0;
        if (j % 2 == 0) m[j] = (j % 4 ? -KRAWTCHOUK.at[8][j] : KRAWTCHOUK.at[8][j]) * p.re[0];
    }
    for (int k = 1; k <= OnCircle<S>::degree; ++k) {
        power = {power.c * turn.c - power.s * turn.s, power.c * turn.s + power.s * turn.c};
        const V re = 2.0 * (power.c * p.re[k] - power.s * p.im[k]), im = 2.0 * (power.c * p.im[k] + power.s * p.re[k]);
        size += 2.0 * (abs(leading(p.re[k])) + abs(leading(p.im[k])));
        const V part[4] = {re, -im, -re, im};
        for (int j = 0; j <= n; ++j) add_product(m[j], V(KRAWTCHOUK.at[8 + k][j]), part[j % 4]);
    }
    V scale = 1.0;
    for (int j = 0; j <= n; ++j) {
        m[j] = m[j] * (scale * On::number(KRAWTCHOUK.over_binomial[j], KRAWTCHOUK.rest[j])), scale = scale * On::number(tau);
    }
    for (int i = 0; i <= n; ++i) {
        b[i] = 0.0;
        for (int j = 0; j <= n; ++j) add_product(b[i], V(KRAWTCHOUK.at[i][j]), m[j]);
    }
    Block wide = 1.0 + tau * tau, lost = 1.0 + tau;
    for (int k = 0; k < 3; ++k) wide = wide * wide;
    for (int k = 0; k < 4; ++k) lost = lost * lost;
    const Block error = SLACK_OF_SUMS * (17.0 * p.error * wide + On::unit * ROUNDING_OF_BERNSTEIN * size * lost);
    // The most changes of sign up to here if the last sign is positive, or negative; an uncertain coefficient may have either.
    Block positive = 0.0, negative = 0.0;
    for (int i = 0; i <= n; ++i) {
        const double change = i ? 1.0 : 0.0, never = -double(n);
        const Block up = max(positive, negative + change), down = max(negative, positive + change);
        positive = select(leading(b[i]) < -error, Block(never), up), negative = select(leading(b[i]) > error, Block(never), down);
    }
    return max(positive, negative);
}

// A bound on the number of zeros on the circle and in the arcs' lenses; -1 if none is found. Where two zeros may be the same, they
// count as two; three are separated, since nothing is proven of a matrix that loses three ranks (eliminant.hpp). known: angles of
// zeros [rad], which are sorted; they decide the cost only, and which pairs need not be separated.
template <class S> PART int zeros_on_circle(const OnCircle<S>& p, double* known, int many) {
    struct Arc {
        double centre, half;
    } arc[MOST_ARCS + 64];
    for (int i = 1; i < many; ++i) {
        const double x = known[i];
        int j = i;
        for (; j > 0 && known[j - 1] > x; --j) known[j] = known[j - 1];
        known[j] = x;
    }
    // Cuts half way between neighbours, and more where they are far apart.
    double cut[48];
    int cuts = 0;
    for (int i = 0; i < many; ++i) {
        const double gap = (i + 1 < many ? known[i + 1] : known[0] + 2.0 * PI) - known[i];
        if (gap < TOGETHER) continue;
        const int parts = 1 + int(gap / WIDEST_ARC);
        for (int k = 0; k < parts && cuts < 48; ++k) cut[cuts++] = known[i] + gap * (k + 0.5) / parts;
    }
    for (int k = 0; !many && k < 12; ++k) cut[cuts++] = 0.1 + k * (PI / 6.0);
    if (cuts == 48 || cuts < 2) return -1;
    int waiting = 0, zeros = 0, seen = 0;
    for (int i = 0; i < cuts; ++i) {
        const double next = i + 1 < cuts ? cut[i + 1] : cut[0] + 2.0 * PI;
        arc[waiting++] = {0.5 * (cut[i] + next), 0.5 * (next - cut[i])};
    }
    while (waiting) {
        const int lanes = waiting < BLOCK ? waiting : BLOCK;
        seen += lanes;
        if (seen > MOST_ARCS) return -1;
        waiting -= lanes;
        Arc now[BLOCK];
        Block centre, half;
        for (int l = 0; l < BLOCK; ++l) {
            now[l] = arc[waiting + (l < lanes ? l : 0)];
            centre.set(l, wrap(now[l].centre)), half.set(l, now[l].half + 0.5 * OVERLAP);
        }
        const Block found = zeros_on(p, centre, half);
        for (int l = 0; l < lanes; ++l) {
            const double low = now[l].centre - now[l].half, high = now[l].centre + now[l].half;
            // The widest gap between the ends and the known zeros in between, from where it starts.
            double last = low, start = low, widest = 0.0;
            int here = 0;
            for (int round = 0; round < 2; ++round) {
                for (int i = 0; i < many; ++i) {
                    const double at = known[i] + 2.0 * PI * round;
                    if (!(at > low && at < high)) continue;
                    if (at - last > widest) widest = at - last, start = last;
                    last = at, ++here;
                }
            }
            if (high - last > widest) widest = high - last, start = last;
            if (found[l] <= (here > 1 ? 2.0 : 1.0)) {
                zeros += int(found[l]);
                continue;
            }
            if (now[l].half < OVERLAP) return -1;
            const double middle = start + widest * (0.5 + CUT);
            arc[waiting++] = {0.5 * (low + middle), 0.5 * (middle - low)};
            arc[waiting++] = {0.5 * (middle + high), 0.5 * (high - middle)};
        }
    }
    return zeros;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
