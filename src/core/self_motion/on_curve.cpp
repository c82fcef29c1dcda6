// Points on the curve of joint vectors that hold a pose; see curve_arm.hpp. Compiled once for every instruction set.
//
// On the curve six equations in seven unknowns hold: the pose error is zero. The tangent is the null space of the Jacobian. The
// minimum-norm step of Newton's method is orthogonal to it (Allgower and Georg, Numerical Continuation Methods, chapter 3).
#include "self_motion/curve_arm.hpp"

#include "answers/answer.hpp"
#include "families/seven_joints/swivel.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

namespace {

// One number per joint, in lanes; the eighth is zero.
using Row = Pack<BLOCK, 8 / BLOCK>;
constexpr int LANES = 8;

// The sum of a register's lanes, by halving.
template <int L> STEP double sum_of(const typename Register<L>::type& r) {
    if constexpr (L == 2) return r[0] + r[1];
    else if constexpr (L == 4) {
        const auto half = __builtin_shufflevector(r, r, 0, 1) + __builtin_shufflevector(r, r, 2, 3);
        return half[0] + half[1];
    } else {
        const auto half = __builtin_shufflevector(r, r, 0, 1, 2, 3) + __builtin_shufflevector(r, r, 4, 5, 6, 7);
        const auto quarter = __builtin_shufflevector(half, half, 0, 1) + __builtin_shufflevector(half, half, 2, 3);
        return quarter[0] + quarter[1];
    }
}
template <int L, int K> STEP double sum(const Pack<L, K>& a) {
    typename Register<L>::type r = a.r[0];
    for (int k = 1; k < K; ++k) r += a.r[k];
    return sum_of<L>(r);
}
STEP double inner(const Row& a, const Row& b) { return sum(a * b); }
STEP Row row_of(const double (&a)[LANES]) {
    Row out;
    __builtin_memcpy(&out, a, sizeof a);
    return out;
}

// Longest step of Newton's method [rad, share of size].
constexpr double LONGEST_STEP = 0.5;
// After orthogonalisation a row of the Jacobian shorter than this cannot be distinguished from rounding.
constexpr double SINGULAR_ROW = 1e-7;
// A search stops after SEARCH_ROUNDS rounds, at the error SEARCH_ENOUGH, or after SEARCH_PATIENCE rounds without progress. It has
// found a point if the error is at most SEARCH_FOUND.
constexpr int SEARCH_ROUNDS = 40, SEARCH_PATIENCE = 14;
constexpr double SEARCH_ENOUGH = 1e-9, SEARCH_FOUND = 1e-6;

// In the base frame: the joints' axes z and origins p, one joint per lane, and the tip.
struct Axes {
    Vec<Row> z, p;
    Frame<double> tip;
};
STEP Axes axes_at(const Written<7>& arm, const Row& q) {
    const Turn<Row> turn = cos_sin(q);
    double z[3][LANES] = {}, p[3][LANES] = {};
    Frame<double> at = constant_frame<double>(arm.step[0]);
#pragma GCC unroll 7
    for (int k = 0; k < 7; ++k) {
        z[0][k] = at.R.z.x, z[1][k] = at.R.z.y, z[2][k] = at.R.z.z;
        p[0][k] = at.p.x, p[1][k] = at.p.y, p[2][k] = at.p.z;
        at = arm.slides[k] ? Frame<double>{at.R, at.p + q[k] * at.R.z} : turned(at, {turn.c[k], turn.s[k]});
        at = beyond(at, arm.step[k + 1]);
    }
    return {{row_of(z[0]), row_of(z[1]), row_of(z[2])}, {row_of(p[0]), row_of(p[1]), row_of(p[2])}, at};
}

// The rows of the Jacobian, lengths as shares of the size.
STEP void rows_at(const FreeArm& arm, const Axes& at, Row (&J)[6]) {
    const Row inverse = 1.0 / arm.written.size, slides = row_of(arm.slides);
    const Vec<Row> lever = {inverse * (Row(at.tip.p.x) - at.p.x), inverse * (Row(at.tip.p.y) - at.p.y),
                            inverse * (Row(at.tip.p.z) - at.p.z)};
    const Vec<Row> v = cross(at.z, lever);
    const Row turns = 1.0 - slides;
    J[0] = turns * v.x + slides * at.z.x, J[1] = turns * v.y + slides * at.z.y, J[2] = turns * v.z + slides * at.z.z;
    J[3] = turns * at.z.x, J[4] = turns * at.z.y, J[5] = turns * at.z.z;
}

// The redundancy parameter and its gradient [per rad, per share of the size].
struct Parameter {
    double value;
    Row slope;
};
// The swivel angle, computed in frame 1; see swivel.hpp.
PART Parameter swivel_at(const FreeArm& arm, const Goal<double>& goal, const Axes& at) {
    const Line<double> line = line_to_wrist(to_frame_1<double>(goal, arm.ends).p);
    const auto of_joint = [&](int k) { return times(arm.ends.base_rotation, Vec<double>{at.z.x[k], at.z.y[k], at.z.z[k]}); };
    const Vec<double> axis = of_joint(3);
    const double c = dot(line.normal, axis), s = dot(line.across, axis), square = c * c + s * s + TINY;
    Parameter out = {angle<double>({c, s}), 0.0};
    for (int k = 0; k < 3; ++k) {
        const Vec<double> turned = cross(of_joint(k), axis);
        out.slope.set(k, (c * dot(line.across, turned) - s * dot(line.normal, turned)) / square);
    }
    return out;
}
STEP Parameter parameter_at(const FreeArm& arm, const Goal<double>& goal, const Axes& at, const Row& q) {
    if (arm.given < 0) return swivel_at(arm, goal, at);
    Parameter out = {q[arm.given], 0.0};
    out.slope.set(arm.given, arm.unit[arm.given]);
    return out;
}

// Equations (row i) x = e[i] after Gram-Schmidt orthogonalisation of the rows and right sides. `inverse` holds one over the squared
// length of each row.
template <int N> struct Orthogonal {
    Row row[N];
    double e[N], inverse[N];

    STEP Orthogonal(const Row (&J)[6], const Rows<6, double>& error, const Row& last, double pinned) {
        for (int i = 0; i < N; ++i) row[i] = i < 6 ? J[i] : last, e[i] = i < 6 ? error[i] : pinned;
#pragma GCC unroll 7
        for (int i = 0; i < N; ++i) {
            inverse[i] = 1.0 / (inner(row[i], row[i]) + TINY);
            for (int k = i + 1; k < N; ++k) {
                const double along = inner(row[i], row[k]) * inverse[i];
                row[k] = row[k] - along * row[i], e[k] -= along * e[i];
            }
        }
    }
    // The minimum-norm solution.
    STEP Row least() const {
        Row x = 0.0;
        for (int i = 0; i < N; ++i) x = x + e[i] * inverse[i] * row[i];
        return x;
    }
    // The unit vector orthogonal to the first six rows: the projection of the joint axis with the longest projection. It is
    // orthogonalised twice, to rounding.
    STEP Row free() const {
        Row left = 1.0, out = 0.0;
        for (int i = 0; i < 6; ++i) left = left - inverse[i] * (row[i] * row[i]);
        int most = 0;
        for (int j = 1; j < 7; ++j) most = left[j] > left[most] ? j : most;
        out.set(most, 1.0);
        for (int again = 0; again < 2; ++again) {
            const Row before = out;
            for (int i = 0; i < 6; ++i) out = out - inner(row[i], before) * inverse[i] * row[i];
        }
        return (1.0 / (sqrt(inner(out, out)) + TINY)) * out;
    }
    // The sign of the determinant of the first six rows and this one, by elimination; 0 if a row is shorter than SINGULAR_ROW.
    STEP int sense(const Row& along) const {
        Row rows[7];
        int sign = 1;
        unsigned lanes = 0x7f;
        for (int i = 0; i < 7; ++i) rows[i] = i < 6 ? row[i] : along;
        for (int i = 0; i < 7; ++i) {
            if (i < 6 && inverse[i] > 1.0 / (SINGULAR_ROW * SINGULAR_ROW)) return 0;
            int most = -1;
            for (int j = 0; j < 7; ++j) most = lanes >> j & 1 && (most < 0 || abs(rows[i][j]) > abs(rows[i][most])) ? j : most;
            const double pivot = rows[i][most];
            // Moving the pivot's column to the front flips the sign once for each remaining lane before it.
            if ((__builtin_popcount(lanes & ((1u << most) - 1)) & 1) != (pivot < 0.0)) sign = -sign;
            lanes &= ~(1u << most);
            for (int k = i + 1; k < 7; ++k) rows[k] = rows[k] - rows[k][most] / pivot * rows[i];
        }
        return sign;
    }
};

OnCurve settle(const FreeArm& arm, const double* T, const double* from, const Pinned& pinned, int rounds, double enough) {
    const Goal<double> goal = goal_of(T);
    const Row slides = row_of(arm.slides), unit = row_of(arm.unit);
    const auto turning = slides < Row(0.5);
    double given[LANES] = {};
    for (int j = 0; j < 7; ++j) given[j] = from[j];
    Row q = row_of(given);
    q = select(turning, wrap(q), q);
    const Row start = q;
    OnCurve out;
    for (int round = 0;; ++round) {
        const Axes at = axes_at(arm.written, q);
        Row J[6];
        rows_at(arm, at, J);
        const Error<double> error = pose_error(goal, at.tip, 1.0 / arm.written.size);
        const Parameter parameter = parameter_at(arm, goal, at, q);
        out.left = error.size;
        double apart = 0.0;
        const bool joint = pinned.what == Pin::joint;
        const int which = joint ? pinned.joint : arm.given;
        const double scale = which < 0 ? 1.0 : arm.unit[which];
        if (pinned.what != Pin::nothing) {
            apart = pinned.value - (joint ? q[which] : parameter.value);
            apart = (which >= 0 && arm.slides[which] > 0.0 ? apart : wrap(apart)) / scale;
            out.left = max(out.left, abs(apart));
        }
        if (!(out.left > enough) || round == rounds) {
            const Orthogonal<6> rows(J, error.twist, 0.0, 0.0);
            const Row along = rows.free();
            out.sense = rows.sense(along);
            for (int j = 0; j < 7; ++j) out.q[j] = q[j], out.along[j] = along[j];
            out.value = parameter.value, out.rate = inner(parameter.slope, along);
            break;
        }
        Row last = (1.0 / scale) * parameter.slope;
        if (joint) last = 0.0, last.set(which, 1.0);
        const Row step = pinned.what == Pin::nothing ? Orthogonal<6>(J, error.twist, 0.0, 0.0).least()
                                                     : Orthogonal<7>(J, error.twist, last, apart).least();
        const double length = sqrt(inner(step, step));
        q = q + (length > LONGEST_STEP ? LONGEST_STEP / length : 1.0) * (unit * step);
        q = select(turning, wrap(q), q);
    }
    Row moved = q - start;
    moved = select(turning, wrap(moved), moved) / unit;
    out.moved = sqrt(inner(moved, moved));
    return out;
}

int search(const FreeArm& arm, const double* T, const double* starts, int count, double* q) {
    const Written<7>& written = arm.written;
    const Goal<Block> goals = spread<Block>(goal_of(T));
    const Block zero = 0.0;
    int many = 0;
    for (int k = 0; k < count; k += BLOCK) {
        Block x[7];
        for (int l = 0; l < BLOCK; ++l) {
            const double* from = starts + 7 * (k + l < count ? k + l : count - 1);
            for (int j = 0; j < 7; ++j) x[j].set(l, written.slides[j] ? from[j] : wrap(from[j]));
        }
        const Block error =
            polish<true, Written<7>, Block>(written, goals, x, {SEARCH_ROUNDS, SEARCH_ENOUGH, SEARCH_PATIENCE}, zero <= zero).error;
        for (int l = 0; l < BLOCK && k + l < count; ++l) {
            if (!(error[l] <= SEARCH_FOUND)) continue;
            for (int j = 0; j < 7; ++j) q[7 * many + j] = x[j][l];
            ++many;
        }
    }
    return many;
}

void errors(const FreeArm& arm, const double* T, const double* q, long count, double* to) {
    const Written<7>& written = arm.written;
    const Goal<Block> goals = spread<Block>(goal_of(T));
    for (long k = 0; k < count; k += BLOCK) {
        const int many = count - k < BLOCK ? int(count - k) : BLOCK;
        Block x[7];
        for (int l = 0; l < BLOCK; ++l) {
            const double* from = q + 7 * (k + (l < many ? l : many - 1));
            for (int j = 0; j < 7; ++j) x[j].set(l, written.slides[j] ? from[j] : wrap(from[j]));
        }
        Block lost = 0.0;
        for (int j = 0; j < 7; ++j) lost = lost + 0.0 * x[j];
        const Block size = pose_error(goals, place(written, x).tip, 1.0 / written.size).size + lost;
        for (int l = 0; l < many; ++l) to[k + l] = size[l];
    }
}

}  // namespace

extern const SelfMotionFunctions self_motion_functions;
const SelfMotionFunctions self_motion_functions = {settle, search, errors};

}  // namespace urdf_ik::URDF_IK_LEVEL
