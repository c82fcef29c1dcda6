// A proof that a ball holds exactly 2^r roots of the loop equation, counted by multiplicity, where the Jacobian all but loses r
// ranks: rank reduction, then Rouche's theorem.
//
// f is the map of loop.hpp at the centre, J its derivative, U and V nearly unitary with U* J V = A, nearly diagonal. y are the
// first 6 - r coordinates of V* d, those of the large singular values, t the other r; g = U* f = (g', g_t), H = U* f''. Where the
// model (A_yy y, H_t,tt(t, t) / 2) exceeds what it leaves out, on the whole boundary of |y| <= across, |t| <= along, g has as many
// zeros as the model, 2^r by Bezout's theorem if the r quadrics have no common zero but t = 0:
//   |y| = across:  s' across > |g'| + |A_yt| along + |H'_tt| along^2 / 2 + |H'_ty| along across + |H'_yy| across^2 / 2 + third
//   |t| = along:   m along^2 > |g_t| + |A_tt| along + |A_ty| across + |H_t,ty| along across + |H_t,yy| across^2 / 2 + third
//   third = (s D)^3 e^(s D) / 6,  D^2 = along^2 + across^2,  s^2 = sum (|v_k|^2 + 2 |w_k|^2)
// m is the smallest singular value of Macaulay's matrix of the quadrics, whose columns are the monomials of degree r + 1, weighted
// by the root of the multinomial coefficient so that a unit vector's have length one, and whose rows are each quadric times each
// monomial of degree r - 1: the product with a unit vector's monomials has the length of the quadrics there. It is zero exactly
// where they have a common zero.
#pragma once

#include "certificate/account.hpp"
#include "certificate/svd.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Radii `along` that are tried, from the largest: quarter decades.
inline constexpr double LARGEST_CLUSTER = 0.1, QUARTER_DECADE = 0.5623413251903491;
inline constexpr int RADII = 27;
// Ranks that may be lost.
inline constexpr int MOST_LOST = 3;
// A quadric's coefficients below this share of the largest are left out when the centre is improved; the centre moves by at most
// LONGEST_MOVE in each of CENTRINGS rounds, and by FARTHEST_CENTRE in all [rad]. None of these decides what is proven.
inline constexpr double WEAKEST_QUADRIC = 1e-6, LONGEST_MOVE = 0.05, FARTHEST_CENTRE = 0.3;
inline constexpr int CENTRINGS = 12;
// A rank counts as lost if its singular value is below WEAK, relative to the largest one. A ball is looked for where Newton's
// method across the small directions moves by less than ACROSS [rad].
// The centre is good enough if it would move by less than MIDDLE of the ball.
inline constexpr double WEAK = 0.05, ACROSS = 1e-9, MIDDLE = 1e-3;
// Imaginary parts below this may be those of a double root's rounding [rad].
inline constexpr double ALMOST_REAL = 1e-3;
// The roots of a cluster stand as one if its centre keeps the pose to this many times the rounding of the loop: where they are
// farther apart, each has a certificate of its own, or has to be found.
inline constexpr double BLURRED = 16.0;
// Rounding of sums of products of six numbers in transformed derivatives, relative to their norms.
inline constexpr double ROUNDING_OF_FORMS = 100.0 * UNIT;

// The loop at one complex joint vector, in the directions of its singular values.
struct Local {
    Number q[6];                // joint values
    Svd<6, 6> J;
    Number g[6], A[6][6];       // A[k][i]: row i of column k
    Number H[6][6][6];          // second derivatives: output, input, input
    double rounding, spread;    // of f; s of the third derivatives
    bool near;                  // whether X's trace is near 3
};

STEP void z_of(const Number (&q)[6], double (&z)[6][2]) {
    for (int k = 0; k < 6; ++k) {
        const Turn<double> t = exact_turn(q[k].re);
        const double length = __builtin_exp(-q[k].im);
        z[k][0] = length * t.c, z[k][1] = length * t.s;
    }
}

// f and J at q, without what clusters need beyond.
STEP LoopAt<Number> loop_at(const Loop& loop, const Number (&q)[6]) {
    double z[6][2];
    z_of(q, z);
    Turn<Number> turn[6];
    for (int k = 0; k < 6; ++k) turn[k] = turn_of(Number(z[k][0], z[k][1]));
    return loop_at(loop, turn);
}

// The singular values of J: in real numbers at real joint vectors.
PART void decompose(const LoopAt<Number>& at, Svd<6, 6>& out) {
    Number columns[6][6];
    double real[6][6], off = 0.0;
    for (int k = 0; k < 6; ++k) {
        for (int i = 0; i < 6; ++i) columns[k][i] = at.twist[k][i], real[k][i] = columns[k][i].re, off += abs(columns[k][i].im);
    }
    if (off > 0.0) return svd(columns, out);
    Svd<6, 6, double> found;
    svd(real, found);
    for (int k = 0; k < 6; ++k) {
        for (int i = 0; i < 6; ++i) out.left[k][i] = found.left[k][i], out.right[k][i] = found.right[k][i];
        out.s[k] = found.s[k];
    }
}

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

// The rest of the numbers at q; J is there.
PART void localise(const Loop& loop, const LoopAt<Number>& at, const Number (&q)[6], Local& out) {
    double growth = 0.0, side[2] = {0.0, 0.0};
    for (int k = 0; k < 6; ++k) growth += abs(q[k].im), side[k / 3] += abs(q[k].im), out.q[k] = q[k];
    const double M = __builtin_exp(growth), m = __builtin_exp(max(side[0], side[1])), l = loop.length;
    out.rounding = M * sqrt(ROUNDING_OF_ROTATION * ROUNDING_OF_ROTATION + loop.rounding * loop.rounding);
    const double of_twist = ROUNDING_OF_TWIST * m * m * (2.0 * l + 1.0);
    out.near = square(at.off) < SAME_BRANCH;
    out.spread = 0.0;
    Six<Number> raw[6][6];
    for (int j = 0; j < 6; ++j) {
        const Vec<Number> w = {at.twist[j][3], at.twist[j][4], at.twist[j][5]};
        for (int i = 0; i < 3; ++i) out.spread += square(at.twist[j][i]) + 2.0 * square(at.twist[j][i + 3]);
        for (int k = j; k < 6; ++k) {
            const Vec<Number> a = cross(w, Vec<Number>{at.twist[k][0], at.twist[k][1], at.twist[k][2]});
            const Vec<Number> b = cross(w, Vec<Number>{at.twist[k][3], at.twist[k][4], at.twist[k][5]});
            raw[j][k] = raw[k][j] = {{a.x, a.y, a.z, 0.5 * b.x, 0.5 * b.y, 0.5 * b.z}};
        }
    }
    out.spread = sqrt(out.spread) + 4.0 * of_twist;
    for (int o = 0; o < 6; ++o) {
        out.g[o] = 0.0;
        for (int i = 0; i < 6; ++i) out.g[o] += conj(out.J.left[o][i]) * at.error[i];
        for (int k = 0; k < 6; ++k) {
            out.A[k][o] = 0.0;
            for (int j = 0; j < 6; ++j) {
                for (int i = 0; i < 6; ++i) out.A[k][o] += conj(out.J.left[o][i]) * at.twist[j][i] * out.J.right[k][j];
            }
        }
        Number first[6][6], half[6][6];
        for (int j = 0; j < 6; ++j) {
            for (int k = 0; k < 6; ++k) {
                first[j][k] = 0.0;
                for (int i = 0; i < 6; ++i) first[j][k] += conj(out.J.left[o][i]) * raw[j][k][i];
            }
        }
        for (int a = 0; a < 6; ++a) {
            for (int k = 0; k < 6; ++k) {
                half[a][k] = 0.0;
                for (int j = 0; j < 6; ++j) half[a][k] += out.J.right[a][j] * first[j][k];
            }
        }
        for (int a = 0; a < 6; ++a) {
            for (int b = 0; b < 6; ++b) {
                out.H[o][a][b] = 0.0;
                for (int k = 0; k < 6; ++k) out.H[o][a][b] += half[a][k] * out.J.right[b][k];
            }
        }
    }
}

// The Frobenius norm of a part of H: outputs from..to, inputs in two ranges.
STEP double norm_of(const Local& at, int o0, int o1, int a0, int a1, int b0, int b1) {
    double sum = 0.0;
    for (int o = o0; o < o1; ++o) {
        for (int a = a0; a < a1; ++a) {
            for (int b = b0; b < b1; ++b) sum += square(at.H[o][a][b]);
        }
    }
    return sqrt(sum) + ROUNDING_OF_FORMS * at.spread * at.spread;
}
// The same of A: columns, rows. `without`: the diagonal left out.
STEP double norm_of(const Local& at, int k0, int k1, int o0, int o1, bool without = false) {
    double sum = 0.0;
    for (int k = k0; k < k1; ++k) {
        for (int o = o0; o < o1; ++o) {
            if (!(without && k == o)) sum += square(at.A[k][o]);
        }
    }
    return sqrt(sum) + ROUNDING_OF_FORMS * at.spread;
}

// m for r = 1, 2, 3. The quadrics are H_t,tt / 2.
PART double least_of_quadrics(const Local& at, int lost) {
    const int n = 6 - lost;
    const auto B = [&](int o, int a, int b) { return at.H[n + o][n + a][n + b]; };
    const double off = ROUNDING_OF_FORMS * at.spread * at.spread;
    if (lost == 1) return max(0.5 * sqrt(square(B(0, 0, 0))) - off, 0.0);
    const double root2 = 1.4142135623730951, root3 = 1.7320508075688772;
    if (lost == 2) {
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
    // Exponents of degree 4 and 2 in three variables.
    Number M[15][18] = {};
    const auto column = [](int a, int b) {  // of t1^a t2^b t3^(4-a-b)
        return (4 - a) * (5 - a) / 2 + (4 - a - b);
    };
    constexpr double factorial[5] = {1.0, 1.0, 2.0, 6.0, 24.0};
    int row = 0;
    for (int o = 0; o < 3; ++o) {
        for (int a = 2; a >= 0; --a) {
            for (int b = 2 - a; b >= 0; --b, ++row) {
                const double weight = a == 2 || b == 2 || a + b == 0 ? 1.0 : root2;
                for (int i = 0; i < 3; ++i) {
                    for (int j = 0; j < 3; ++j) {
                        const int x = a + (i == 0) + (j == 0), y = b + (i == 1) + (j == 1), z = 4 - x - y;
                        const double all = sqrt(24.0 / (factorial[x] * factorial[y] * factorial[z]));
                        M[column(x, y)][row] += (0.5 * weight / all) * B(o, i, j);
                    }
                }
            }
        }
    }
    Svd<18, 15> out;
    svd(M, out);
    return max(out.s[14] - 18.0 * off, 0.0);
}

// The smallest ball that is proven to hold 2^lost roots; along is 0 if none is. largest: the largest one.
struct Ball {
    double across, along, largest_across, largest_along, m;
    bool blurred;  // the roots are nearer to each other than rounding
};
PART Ball ball_of(const Local& at, int lost) {
    const int n = 6 - lost;
    Ball out = {0.0, 0.0, 0.0, 0.0, least_of_quadrics(at, lost), false};
    if (!at.near || !(out.m > 0.0)) return out;
    double f_y = 0.0, f_t = 0.0;
    for (int o = 0; o < 6; ++o) (o < n ? f_y : f_t) += square(at.g[o]);
    const double size = sqrt(f_y + f_t);
    f_y = sqrt(f_y) + at.rounding, f_t = sqrt(f_t) + at.rounding;
    const double least = at.J.s[n - 1] - norm_of(at, 0, n, 0, n, true);
    const double A_yt = norm_of(at, n, 6, 0, n), A_ty = norm_of(at, 0, n, n, 6), A_tt = norm_of(at, n, 6, n, 6);
    const double y_tt = norm_of(at, 0, n, n, 6, n, 6), y_ty = norm_of(at, 0, n, 0, n, n, 6), y_yy = norm_of(at, 0, n, 0, n, 0, n);
    const double t_ty = norm_of(at, n, 6, 0, n, n, 6), t_yy = norm_of(at, n, 6, 0, n, 0, n);
    double R = LARGEST_CLUSTER;
    for (int k = 0; k < RADII; ++k, R *= QUARTER_DECADE) {
        const double s = at.spread, base = f_y + A_yt * R + 0.5 * y_tt * R * R, slope = least - y_ty * R;
        if (!(slope > 0.0)) continue;
        // Any value may be tried: twice what the first-order terms ask for.
        const double rho = 2.0 * (base + s * R * s * R * s * R / 3.0) / slope, D = sqrt(R * R + rho * rho);
        if (!(s * D < LARGEST_BALL)) continue;
        const double third = s * D * s * D * s * D * GROWTH / 6.0;
        const bool y = slope * rho > SLACK_OF_SUMS * (base + 0.5 * y_yy * rho * rho + third);
        const bool t =
            out.m * R * R > SLACK_OF_SUMS * (f_t + A_tt * R + A_ty * rho + t_ty * R * rho + 0.5 * t_yy * rho * rho + third);
        if (!y || !t) continue;
        if (out.along == 0.0) out.largest_across = rho, out.largest_along = R;
        out.across = rho, out.along = R;
    }
    out.blurred = size <= BLURRED * at.rounding && A_tt * out.along <= BLURRED * at.rounding;
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
    Ball ball = {};
    bool near = false;
    for (int round = 0; round < CENTRINGS; ++round) {
        const LoopAt<Number> loop_here = loop_at(loop, q);
        decompose(loop_here, at.J);
        if (!(at.J.s[6 - lost] < WEAK * at.J.s[0])) return false;
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
        ball = ball_of(at, lost);
        if (!(ball.m > 0.0)) break;
        const double size = lost == 1 ? recentred<1>(at, next) : lost == 2 ? recentred<2>(at, next) : recentred<3>(at, next);
        // A ball about the middle of the roots is the smallest.
        if (size < (ball.along > 0.0 ? MIDDLE * ball.along : 1e-13) || round + 3 > CENTRINGS) break;
        for (int k = 0; k < 6; ++k) q[k] = next[k];
        near = false;
    }
    if (!(ball.along > 0.0)) return false;
    for (int k = 0; k < 6; ++k) {
        out.q[k] = at.q[k];
        for (int j = 0; j < 6; ++j) out.direction[k][j] = at.J.right[k][j];
    }
    // The two roots of g_t + A_tt t + H_t,tt t^2 / 2 = 0 lead to two real members.
    const double A = at.A[5][5].re, H = at.H[5][5][5].re, square_root = A * A - 2.0 * H * at.g[5].re;
    out.starts = lost == 1 && square_root > 0.0 ? 2 : 0;
    for (int i = 0; i < out.starts; ++i) {
        const double t = ((i ? -1.0 : 1.0) * sqrt(square_root) - A) / H;
        for (int k = 0; k < 6; ++k) out.start[i][k] = wrap(wrap(at.q[k].re) + t * at.J.right[5][k].re);
    }
    out.across = ball.across, out.along = ball.along, out.lost = lost, out.blurred = ball.blurred;
    out.larger_across = ball.largest_across, out.larger_along = ball.largest_along;
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
