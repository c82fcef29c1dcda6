// A proof that a ball holds exactly 2^r roots of the loop equation, counted by multiplicity, where the Jacobian all but loses r
// ranks: rank reduction, then Rouche's theorem.
//
// f is the map of loop.hpp at the centre, J its derivative, U and V nearly unitary with U* J V = A, nearly diagonal. y are the
// first 6 - r coordinates of V* d, those of the large singular values, t the other r; g = U* f = (g', g_t), H = U* f''. Where the
// model (A_yy y, H_t,tt(t, t) / 2) exceeds what it leaves out, on the whole boundary of |y| <= across, |t| <= along, g has as many
// zeros as the model, 2^r by Bezout's theorem if the r quadrics have no common zero but t = 0:
//   |y| = across:  s' across > |g'| + |A_yt| along + |H'_tt| along^2 / 2 + |H'_ty| along across + |H'_yy| across^2 / 2 + third
//   |t| = along:   m along^2 > |g_t| + |A_tt| along + |A_ty| across + |H_t,ty| along across + |H_t,yy| across^2 / 2 + third
//   third = |T_ttt| along^3 + s across x^2 e^x / 2 + (s_t along)^4 e^x / 24,  x = s_t along + s across >= sum_k |d_k| |zeta_k|,
//   s^2 = sum_k |zeta_k|^2,  s_t^2 = sum_t (sum_k |V_kt| |zeta_k|)^2,  |zeta_k|^2 = |v_k|^2 + 2 |w_k|^2
// since sum_(n > 2) (x^n - (s_t along)^n) / n! <= s across x^2 e^x / 2.
// If the first condition also holds with a larger `across` on its left side and in the terms of y, it holds in between, since its
// right side is convex in |y|: the larger region has no further root.
// T_ttt are the terms of third order in t alone, of the output at hand: the coefficients of the product of exponentials. m is
// |H_t,tt| / 2 for r = 1. For r = 2 it is the smallest singular value of Sylvester's matrix of the two quadrics, whose columns are
// the cubic monomials, weighted by the root of the binomial coefficient so that a unit vector's have length one, and whose rows are
// each quadric times each variable: the product with a unit vector's monomials has the length of the quadrics there. It is zero
// exactly where they have a common zero.
#pragma once

#include "certificate/account.hpp"
#include "certificate/series.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Radii `along` that are tried, from the largest: quarter decades.
inline constexpr double LARGEST_CLUSTER = 0.1, QUARTER_DECADE = 0.5623413251903491;
inline constexpr int RADII = 27;
// Ranks that may be lost.
inline constexpr int MOST_LOST = 2;
// A quadric's coefficients below this share of the largest are left out when the centre is improved; the centre moves by at most
// LONGEST_MOVE in each of CENTRINGS rounds, and by FARTHEST_CENTRE in all [rad]. None of these decides what is proven.
inline constexpr double WEAKEST_QUADRIC = 1e-6, LONGEST_MOVE = 0.05, FARTHEST_CENTRE = 0.3;
inline constexpr int CENTRINGS = 24;
// A rank counts as lost if its singular value is below WEAK, relative to the largest one. A ball is looked for where Newton's
// method across the small directions moves by less than ACROSS [rad].
// The centre is good enough if it would move by less than MIDDLE of the ball. No ball is looked for where one more singular value
// is below LOST_TOO: the ball would be smaller still.
inline constexpr double WEAK = 0.05, ACROSS = 1e-9, MIDDLE = 1e-3, LOST_TOO = 1e-6;
// Imaginary parts below this may be those of a double root's rounding [rad].
inline constexpr double ALMOST_REAL = 1e-3;
// The roots of a cluster stand as one if its centre keeps the pose to this many times the rounding of the loop: where they are
// farther apart, each has a certificate of its own, or has to be found.
inline constexpr double BLURRED = 16.0;
// A joint vector that keeps the pose to this without being a solution may stand for one.
inline constexpr double NEARLY_KEPT = 1e-10;

// A step of Newton's method in the directions of the 6 - lost large singular values. Returns its length.
STEP double step_across(const LoopAt<Number>& at, const Svd<6, 6>& J, int lost, Number (&q)[6]) {
    Number x[6] = {};
    for (int k = 0; k < 6 - lost; ++k) {
        Number along = 0.0;
        for (int i = 0; i < 6; ++i) along += conj(J.left[k][i]) * at.error[i];
        for (int j = 0; j < 6; ++j) x[j] += (1.0 / J.s[k]) * along * J.right[k][j];
    }
    double size = 0.0;
    for (const Number& each : x) size = max(size, sqrt(square(each)));
    for (int j = 0; j < 6; ++j) q[j] = q[j] + min(1.0, FARTHEST_CENTRE / (size + TINY)) * x[j];
    return size;
}

// m. The quadrics are H_t,tt / 2.
PART double least_of_quadrics(const Local& at, int lost) {
    const int n = 6 - lost;
    const auto B = [&](int o, int a, int b) { return at.H[n + o][n + a][n + b]; };
    const double off = ROUNDING_OF_FORMS * at.spread * at.spread;
    if (lost == 1) return max(0.5 * sqrt(square(B(0, 0, 0))) - off, 0.0);
    const double root3 = 1.7320508075688772;
    // Monomials t1^3, t1^2 t2, t1 t2^2, t2^3 weighted by 1, root 3, root 3, 1.
    Number M[4][4] = {};
    for (int o = 0; o < 2; ++o) {
        const Number a = 0.5 * B(o, 0, 0), b = B(o, 0, 1), c = 0.5 * B(o, 1, 1);
        M[0][2 * o] = a, M[1][2 * o] = (1.0 / root3) * b, M[2][2 * o] = (1.0 / root3) * c;
        M[1][2 * o + 1] = (1.0 / root3) * a, M[2][2 * o + 1] = (1.0 / root3) * b, M[3][2 * o + 1] = c;
    }
    Svd<4, 4> out;
    svd(M, out);
    return max(out.s[3] - 4.0 * off, 0.0);
}

// The smallest ball that is proven to hold so many roots; along is 0 if none is. largest: the largest one.
struct Region {
    double across, along, largest_across, largest_along, m;
    double rest;  // what g_t may differ from its terms up to the second order in t by in the smallest ball
    bool blurred;  // the roots are nearer to each other than rounding
};
// Bounds on what a ball's first and second derivatives have outside of the model: |A_yy y| is at least `least` |y|.
struct Norms {
    double least, A_ty, y_ty, y_yy, t_ty, t_yy, s_t;
};
PART Norms norms_of(const Local& at, int lost) {
    const int n = 6 - lost;
    double sum_t = 0.0;
    for (int v = n; v < 6; ++v) {
        double sum = 0.0;
        for (int k = 0; k < 6; ++k) sum += at.length[k] * sqrt(square(at.J.right[v][k]));
        sum_t += sum * sum;
    }
    return {at.J.s[n - 1] - norm_of(at, 0, n, 0, n, true),
            norm_of(at, 0, n, n, 6),
            norm_of(at, 0, n, 0, n, n, 6),
            norm_of(at, 0, n, 0, n, 0, n),
            norm_of(at, n, 6, 0, n, n, 6),
            norm_of(at, n, 6, 0, n, 0, n),
            min(SLACK_OF_SUMS * sqrt(sum_t), at.spread)};
}
// Bounds on the terms in t alone, by order, of the first outputs and of the others; the quadrics are not among these.
struct TermsInT {
    double y[4], t[4];
};
PART TermsInT terms_in_t(const Local& at, int lost) {
    const int n = 6 - lost;
    const ThirdOrder third = third_order(at, lost);
    return {{0.0, norm_of(at, n, 6, 0, n), 0.5 * norm_of(at, 0, n, n, 6, n, 6), third.y},
            {0.0, norm_of(at, n, 6, n, 6), 0.0, third.t}};
}
// Their sum at |t| = R.
STEP double in_t_alone(const double (&terms)[4], double R) { return R * (terms[1] + R * (terms[2] + R * terms[3])); }

PART Region ball_of(const Local& at, int lost, const Norms& norms) {
    const int n = 6 - lost;
    double f_y = 0.0, f_t = 0.0;
    for (int o = 0; o < 6; ++o) (o < n ? f_y : f_t) += square(at.g[o]);
    const double size = sqrt(f_y + f_t), s = at.spread;
    Region out = {};
    out.m = least_of_quadrics(at, lost);
    if (!at.near || !(out.m > 0.0)) return out;
    f_y = sqrt(f_y) + at.rounding, f_t = sqrt(f_t) + at.rounding;
    const auto& [least, A_ty, y_ty, y_yy, t_ty, t_yy, s_t] = norms;
    const auto [y, t] = terms_in_t(at, lost);
    double R = LARGEST_CLUSTER;
    for (int k = 0; k < RADII; ++k, R *= QUARTER_DECADE) {
        const double a = s_t * R, beyond = GROWTH * a * a * a * a / 24.0;
        if (!(a < LARGEST_BALL)) continue;
        const double base = f_y + in_t_alone(y, R) + beyond, slope = least - y_ty * R;
        if (!(slope > 0.0)) continue;
        // Terms from the third order on that are not in t alone.
        const auto higher = [&](double rho) { return 0.5 * GROWTH * s * rho * square(a + s * rho); };
        // Any value may be tried: twice what the terms in t alone ask for.
        const double rho = 2.0 * base / slope;
        const auto outside = [&, y_yy = y_yy](double rho) {
            return a + s * rho < LARGEST_BALL && slope * rho > SLACK_OF_SUMS * (base + 0.5 * y_yy * rho * rho + higher(rho));
        };
        if (!outside(rho)) continue;
        const double left = (A_ty + t_ty * R) * rho + 0.5 * t_yy * rho * rho + higher(rho) + beyond;
        if (!(out.m * R * R > SLACK_OF_SUMS * (in_t_alone(t, R) + f_t + left))) continue;
        if (out.along == 0.0) {
            out.largest_across = rho, out.largest_along = R;
            // By halving: any larger one that holds may be taken.
            double wide = LARGEST_CLUSTER;
            for (int halving = 0; halving < 6; ++halving) {
                const double between = sqrt(out.largest_across * wide);
                (outside(between) ? out.largest_across : wide) = between;
            }
        }
        out.across = rho, out.along = R;
        out.rest = SLACK_OF_SUMS * (left + t[3] * R * R * R + at.rounding + ROUNDING_OF_FORMS * s * R * (1.0 + s * R));
    }
    out.blurred = max(size, t[1] * out.along) <= BLURRED * at.rounding;
    return out;
}

// Towards the middle of the roots: to where A_tt vanishes, to first order and in the least-squares sense.
template <int r> PART double recentred(const Local& at, Number (&q)[6]) {
    constexpr int n = 6 - r;
    Number columns[r][r * r], wanted[r * r];
    for (int i = 0; i < r; ++i) {
        for (int o = 0; o < r; ++o) {
            wanted[r * i + o] = at.A[n + i][n + o];
            for (int k = 0; k < r; ++k) columns[k][r * i + o] = at.H[n + o][n + i][n + k];
        }
    }
    Svd<r * r, r> B;
    svd(columns, B);
    Number d[6] = {};
    double size = 0.0;
    for (int k = 0; k < r; ++k) {
        if (!(B.s[k] > WEAKEST_QUADRIC * B.s[0]) || !(B.s[k] > TINY)) continue;
        const Number along = (-1.0 / B.s[k]) * inner_product(B.left[k], wanted);
        for (int i = 0; i < r; ++i) {
            for (int j = 0; j < 6; ++j) d[j] += along * B.right[k][i] * at.J.right[n + i][j];
        }
    }
    for (const Number& each : d) size = max(size, sqrt(square(each)));
    for (int j = 0; j < 6; ++j) q[j] = q[j] + min(1.0, LONGEST_MOVE / (size + TINY)) * d[j];
    return size;
}

// The two roots of g_t + A_tt t + H_t,tt t^2 / 2 = 0 lead to two real members.
PART void set_members(const Local& at, const Region& ball, Cluster& out) {
    const double A = at.A[5][5].re, H = at.H[5][5][5].re, square_root = A * A - 2.0 * H * at.g[5].re;
    out.starts = out.lost == 1 && square_root > 0.0 ? 2 : 0;
    // On the real line the quadratic stays -square_root / (2 H) away from zero.
    out.apart = out.lost == 1 && is_real(at.q) && -square_root > 2.0 * abs(H) * (ball.rest + NEARLY_KEPT);
    for (int i = 0; i < out.starts; ++i) {
        const double t = ((i ? -1.0 : 1.0) * sqrt(square_root) - A) / H;
        for (int k = 0; k < 6; ++k) out.start[i][k] = wrap(wrap(at.q[k].re) + t * at.J.right[5][k].re);
    }
}

// A cluster of 2^lost roots near the candidate q. Returns whether one is proven.
PART bool cluster_near(const Loop& loop, const Number (&from)[6], int lost, Cluster& out) {
    Number q[6];
    for (int k = 0; k < 6; ++k) q[k] = from[k];
    const auto moved = [&] {
        double most = 0.0;
        for (int k = 0; k < 6; ++k) most = max(most, sqrt(square(q[k] - from[k])));
        return most;
    };
    Local at;
    Region ball = {};
    bool near = false;
    double last = __builtin_inf();
    for (int round = 0; round < CENTRINGS; ++round) {
        const LoopAt<Number> loop_here = loop_at(loop, q);
        decompose(loop_here, at.J);
        if (!(at.J.s[6 - lost] < WEAK * at.J.s[0]) || at.J.s[5 - lost] < LOST_TOO * at.J.s[0]) return false;
        Number next[6];
        for (int k = 0; k < 6; ++k) next[k] = q[k];
        const double step = step_across(loop_here, at.J, lost, next);
        if (!(step < 1e3) || moved() > FARTHEST_CENTRE) return false;
        // One more step than needed: quadratic convergence leaves rounding only.
        if (!near) {
            near = step <= ACROSS;
            for (int k = 0; k < 6; ++k) q[k] = next[k];
            continue;
        }
        localise(loop, loop_here, q, at);
        const double size = lost == 1 ? recentred<1>(at, next) : recentred<2>(at, next);
        ball = {};
        if (size < LARGEST_CLUSTER) ball = ball_of(at, lost, norms_of(at, lost));
        if (size < LARGEST_CLUSTER && !(ball.m > 0.0)) break;
        // Rounding leaves no better centre.
        if (size > last && size < LARGEST_CLUSTER) break;
        last = size;
        // A ball about the middle of the roots is the smallest.
        if (size < (ball.along > 0.0 ? MIDDLE * ball.along : 1e-13) || round + 3 > CENTRINGS) break;
        for (int k = 0; k < 6; ++k) q[k] = next[k];
        near = false;
    }
    out.across = ball.across, out.larger_across = ball.largest_across;
    if (!(ball.along > 0.0 && out.across <= out.larger_across)) return false;
    for (int k = 0; k < 6; ++k) {
        out.q[k] = at.q[k];
        for (int j = 0; j < 6; ++j) out.direction[k][j] = at.J.right[k][j];
    }
    out.along = ball.along, out.larger_along = ball.largest_along;
    out.lost = lost, out.many = 1 << lost, out.blurred = ball.blurred;
    set_members(at, ball, out);
    return true;
}

// Adds the cluster near an uncertified joint vector, if one is proven, and its conjugate if that is another one. A joint vector
// that is almost real is tried as a real one: the cluster's centre is then real, too.
PART bool add_cluster_near(const Loop& loop, Account& account, const Number (&from)[6]) {
    Number q[6];
    double off = 0.0;
    for (int k = 0; k < 6; ++k) off = max(off, abs(from[k].im));
    for (int k = 0; k < 6; ++k) q[k] = off < ALMOST_REAL ? Number(from[k].re) : from[k];
    for (int i = 0; i < account.clusters; ++i) {
        if (is_inside_larger(account.cluster[i], q)) return true;
    }
    for (int lost = 1; lost <= MOST_LOST; ++lost) {
        Cluster found;
        if (!cluster_near(loop, q, lost, found)) continue;
        if (!add_cluster(account, found)) return false;
        Cluster other = found;
        for (int k = 0; k < 6; ++k) {
            other.q[k] = conj(found.q[k]);
            for (int j = 0; j < 6; ++j) other.direction[k][j] = conj(found.direction[k][j]);
        }
        add_cluster(account, other);
        return true;
    }
    return false;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
