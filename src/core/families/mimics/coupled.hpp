// Arms whose joints drive several axes each, by bisection: every part of the joint space is excluded or solved.
//
// In the scaled joints x the error of the tip is f(x) = ((p - p_target) / size, (R - R_target) / sqrt 2), twelve
// numbers. In a box |x - c| <= w it is f(c) + J (x - c) + r with |r| <= rho(w), since second derivatives of a product
// of exponentials are bounded by its links' lengths and their rates of turning. The box holds no solution if f cannot
// vanish in it: its size at c is too large, its part across the range of J is, or the least-squares step leaves the
// box. The box holds at most one solution, and Newton's method leads to it from the middle, if that step contracts
// (Neumaier, Interval Methods for Systems of Equations, 1990, chapter 5). All other boxes are halved. At double roots
// and on continua this does not end, so the centres of the smallest boxes become starts.
#pragma once

#include "arm/target.hpp"
#include "families/mimics/coupled_model.hpp"
#include "numbers/ball.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// If more boxes than STARTS remain, only about STARTS of them become starts. Halving ends when rho is below SMALLEST
// squared [rad].
inline constexpr long STARTS = 400;
inline constexpr double SMALLEST = 2e-4;
// Rounding of the error's length: of MOST_AXES axes as in certify/loop.hpp, (14 n^2 + 62 n) 2^-53; the contraction that
// Newton's step needs.
inline constexpr double ERROR_ROUNDING = 4e-13, CONTRACTING = 0.25;
// A diagonal entry of the triangular factor below this share of its column: the columns depend on one another.
inline constexpr double DEPENDENT = 1e-10;

// rho: a bound on the second and higher orders of the error in a box of half widths w, wherever the box lies. The tip
// is the sum of the links, each turned by all axes before it. The second derivative of a rotation is at most the square
// of its rate.
template <int N> STEP double bound(const CoupledArm<N>& arm, const double (&w)[N]) {
    const auto& written = arm.written;
    double place = 0.0, rate = 0.0;
    for (int k = 0; k < written.axes; ++k) {
        double slide = 0.0, extent = 0.0;
        rate = 0.0;
        for (int j = 0; j < N; ++j) {
            rate += arm.rates[k][j] * w[j];
            if (!written.slides[k]) continue;
            slide += abs(written.gain[k][j]) * w[j];
            extent += abs(written.gain[k][j]) * (abs(arm.middle[j]) + arm.half[j]);
        }
        const double* t = written.step[k + 1].t;
        const double link = sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]) + extent;
        place += link * rate * rate + 2.0 * slide * rate;
    }
    place /= written.size;
    return 0.5 * sqrt(place * place + rate * rate * rate * rate) * INFLATED;
}

// One bit per box. alone: it holds at most one solution, and `start` leads to it. halve: this is open. The others hold
// none.
template <int N> struct Verdict {
    unsigned alone, halve;
    Block start[N];
};

template <int N> PART Verdict<N> examine(const Coupled<N>& arm, const Goal<double>& goal, const Block (&c)[N], const double (&w)[N],
                                         double rho) {
    const CoupledPosture<Block> at = place(arm, c);
    const Goal<Block> wanted = spread<Block>(goal);
    const Error<Block> e = pose_error(wanted, at.tip, 1.0 / arm.size);
    Six<Block> J[N];
    jacobian_at(arm, at, J);
    // |R - R_target|^2 / 2 = 3 - tr(R' R_target).
    const Vec<Block> dx = at.tip.R.x - wanted.R.x, dy = at.tip.R.y - wanted.R.y, dz = at.tip.R.z - wanted.R.z;
    const Block square = e.twist[0] * e.twist[0] + e.twist[1] * e.twist[1] + e.twist[2] * e.twist[2] +
                         0.5 * (dot(dx, dx) + dot(dy, dy) + dot(dz, dz));
    Block reach = rho;
    for (int j = 0; j < N; ++j) reach += sqrt(dot(J[j], J[j])) * w[j];
    const Block wide_reach = reach + ERROR_ROUNDING, wide_rho = rho + ERROR_ROUNDING;
    auto none = square > wide_reach * wide_reach, dependent = square < Block(-1.0);
    // The twelve-row Jacobian has the same products with itself and with the error as the geometric one.
    Block L[N][N], inverse[N][N], y[N], along = 0.0, least = 1.0;
    for (int a = 0; a < N; ++a) {
        for (int b = 0; b <= a; ++b) {
            Block s = dot(J[a], J[b]);
            const Block whole = s;
            for (int k = 0; k < b; ++k) s -= L[a][k] * L[b][k];
            if (a > b) {
                L[a][b] = s * inverse[b][b];
                continue;
            }
            least = min(least, s / max(whole, TINY));
            dependent = dependent | !(s >= DEPENDENT * whole) | !(whole > Block(0.0));
            inverse[a][a] = 1.0 / sqrt(max(s, TINY));
        }
        // Rows of the inverse of L, whose columns' squares add up to the diagonal of the inverse of J'J.
        y[a] = inverse[a][a] * dot(J[a], e.twist);
        for (int b = 0; b < a; ++b) {
            Block s = 0.0;
            for (int k = b; k < a; ++k) s -= L[a][k] * inverse[k][b];
            inverse[a][b] = s * inverse[a][a];
            y[a] += inverse[a][b] * dot(J[b], e.twist);
        }
        along += y[a] * y[a];
    }
    // The relative error of a projection by the triangular factor: a few roundings over the least share that is left of a column.
    const Block lost = 1e-14 / max(least, DEPENDENT);
    auto outside = square - along > wide_rho * wide_rho + lost * along, wide = square < Block(-1.0);
    Verdict<N> out;
    for (int j = 0; j < N; ++j) {
        Block step = 0.0, row = 0.0;
        for (int a = j; a < N; ++a) step += inverse[a][j] * y[a], row += inverse[a][j] * inverse[a][j];
        row = sqrt(row);
        outside = outside | (abs(step) > w[j] + row * rho + 1e-9 + lost * abs(step));
        wide = wide | (2.0 * row * rho > Block(CONTRACTING * w[j]));
        out.start[j] = c[j] + step;
    }
    none = none | (outside & !dependent);
    out.halve = bits(!none & (dependent | wide)), out.alone = bits(!none & !dependent & !wide);
    return out;
}

// The joint whose halving lowers the bound most.
template <int N> STEP int widest(const CoupledArm<N>& arm, const double (&w)[N]) {
    int best = 0;
    double least = __builtin_inf();
    for (int j = 0; j < N; ++j) {
        double halved[N];
        for (int i = 0; i < N; ++i) halved[i] = i == j ? 0.5 * w[i] : w[i];
        const double each = bound(arm, halved);
        if (each < least) least = each, best = j;
    }
    return best;
}

// All solutions of one pose, scaled; boxes and halves are scratch for BOXES boxes each. Returns whether every box was decided.
template <int N>
PART bool search(const CoupledArm<N>& arm, const Goal<double>& goal, double* boxes, double* halves, const Columns<N>& columns) {
    double w[N];
    for (int j = 0; j < N; ++j) w[j] = arm.half[j], boxes[j] = arm.middle[j];
    bool decided = true;
    for (long count = 1; count > 0;) {
        const double rho = bound(arm, w);
        const bool last = rho < SMALLEST * SMALLEST || 2 * count > BOXES;
        const int split = widest(arm, w);
        const long stride = last ? 1 + count / STARTS : 1;
        decided &= stride == 1;
        long more = 0;
        for (long first = 0; first < count; first += BLOCK * stride) {
            Block c[N];
            for (int i = 0; i < BLOCK; ++i) {
                const long box = first + i * stride < count ? first + i * stride : first;
                for (int j = 0; j < N; ++j) c[j].set(i, boxes[N * box + j]);
            }
            const Verdict<N> verdict = examine(arm.written, goal, c, w, rho);
            for (int i = 0; i < BLOCK && first + i * stride < count; ++i) {
                const bool alone = verdict.alone >> i & 1, halve = verdict.halve >> i & 1;
                decided &= !(halve && last);
                double x[N];
                for (int j = 0; j < N; ++j) x[j] = alone ? verdict.start[j][i] : c[j][i];
                if (alone || (halve && last)) {
                    polish_and_keep(arm.written, goal, x, !alone, columns);
                } else if (halve) {
                    for (int side = -1; side <= 1; side += 2, ++more) {
                        for (int j = 0; j < N; ++j) halves[N * more + j] = x[j] + (j == split ? 0.5 * side * w[j] : 0.0);
                    }
                }
            }
        }
        if (last) return decided;
        w[split] *= 0.5, count = more;
        exchange(boxes, halves);
    }
    return decided;
}

template <int N> long solve_coupled(const CoupledArm<N>& arm, const Batch& batch, double* scratch) {
    for (long i = 0; i < batch.m; ++i) {
        double T[16], proper[16];
        for (int k = 0; k < 16; ++k) T[k] = batch.T[16 * i + k];
        if (!(pose_defect<double>(T) <= arm.written.tolerances.rotation)) return i;
        project_rotation(T, proper);
        const Columns<N> columns = {batch.q + N * arm.columns * i, batch.flags + arm.columns * i, arm.columns};
        columns.clear();
        bool decided = search(arm, goal_of(proper), scratch, scratch + N * BOXES, columns);
        decided &= !columns.valid(arm.columns - 1);  // what found no free column was dropped
        finish(arm.written, columns);
        if (!decided) set_status(columns.flags[0], Status::incomplete);
    }
    return -1;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
