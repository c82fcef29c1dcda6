// Points on the curve of joint vectors that hold a pose; see curve_arm.hpp. Compiled once for every instruction set.
//
// On the curve six equations in seven unknowns hold: the pose error is zero. The tangent is the null space of the Jacobian. The
// minimum-norm step of Newton's method is orthogonal to it (Allgower and Georg, Numerical Continuation Methods, chapter 3).
#include "motion/self_motion/curve_arm.hpp"

#include <algorithm>
#include <vector>

#include "families/seven_joints/swivel.hpp"
#include "propose/answer.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

namespace {

// Longest step of Newton's method [rad, share of size].
constexpr double LONGEST_STEP = 0.5;
// A search stops after SEARCH_ROUNDS rounds, at the error NEARLY_EXACT, or after SEARCH_PATIENCE rounds without progress. It has
// found a point if the error is at most SAME. Most starts end within SEARCH_FIRST rounds; the others go on side by side.
constexpr int SEARCH_ROUNDS = 40, SEARCH_FIRST = 5, SEARCH_PATIENCE = 14;

// The redundancy parameter and its gradient [per rad, per share of the size].
struct Parameter {
    Block value, slope[7];
};
// The swivel angle, computed in frame 1; see swivel.hpp.
PART Parameter swivel_at(const FreeArm& arm, const Goal<Block>& goal, const Posture<7, Block>& at) {
    const Line<Block> line = line_to_wrist(to_frame_1<Block>(goal, arm.ends).p);
    const auto of_joint = [&](int k) { return times(arm.ends.base_rotation, at.joint[k].R.z); };
    const Vec<Block> axis = of_joint(3);
    const Block c = dot(line.normal, axis), s = dot(line.across, axis), square = c * c + s * s + TINY;
    Parameter out = {angle<Block>({c, s}), {}};
    for (int k = 0; k < 7; ++k) {
        const Vec<Block> turned = cross(of_joint(k), axis);
        out.slope[k] = k < 3 ? (c * dot(line.across, turned) - s * dot(line.normal, turned)) / square : Block(0.0);
    }
    return out;
}
STEP Parameter parameter_at(const FreeArm& arm, const Goal<Block>& goal, const Posture<7, Block>& at, const Block (&q)[7]) {
    if (arm.given < 0) return swivel_at(arm, goal, at);
    Parameter out = {q[arm.given], {}};
    for (int j = 0; j < 7; ++j) out.slope[j] = j == arm.given ? arm.unit[j] : 0.0;
    return out;
}

STEP Block inner(const Block (&a)[7], const Block (&b)[7]) {
    Block sum = a[0] * b[0];
    for (int j = 1; j < 7; ++j) sum += a[j] * b[j];
    return sum;
}

// Rows of seven numbers, each reflected by those before it (Householder 1958; Golub and Van Loan, Matrix Computations, chapter 5).
// Reflection i turns row i into r[i] times axis i, beside its parts on the axes before. row[i] holds these parts, and from entry i
// on the reflection's vector; weight[i] is two over its squared length.
template <int N> struct Reflected {
    Block row[N][7], r[N], weight[N];

    STEP Reflected(const Six<Block> (&J)[7], const Block* last) {
        for (int i = 0; i < N; ++i) {
            for (int j = 0; j < 7; ++j) row[i][j] = i < 6 ? J[j][i] : last[j];
        }
#pragma GCC unroll 7
        for (int i = 0; i < N; ++i) {
            Block square = TINY;
            for (int j = i; j < 7; ++j) square += row[i][j] * row[i][j];
            r[i] = copysign(sqrt(square), -row[i][i]);
            row[i][i] -= r[i];
            weight[i] = -1.0 / (r[i] * row[i][i]);
            for (int k = i + 1; k < N; ++k) reflect(i, row[k]);
        }
    }
    STEP void reflect(int i, Block (&x)[7]) const {
        Block along = row[i][i] * x[i];
        for (int j = i + 1; j < 7; ++j) along += row[i][j] * x[j];
        for (int j = i; j < 7; ++j) x[j] -= weight[i] * along * row[i][j];
    }
    // The minimum-norm solution of (row i) x = e[i].
    STEP void least(const Block (&e)[7], Block (&x)[7]) const {
        for (int i = 0; i < 7; ++i) {
            x[i] = i < N ? e[i] : Block(0.0);
            for (int k = 0; k < i && i < N; ++k) x[i] -= row[i][k] * x[k];
            if (i < N) x[i] = x[i] / r[i];
        }
#pragma GCC unroll 7
        for (int i = N - 1; i >= 0; --i) reflect(i, x);
    }
    // The unit vector orthogonal to the first six rows. Returns the sign of the determinant of these rows and this vector; 0 if
    // rounding decides it: a row's part that those before it lack is shorter than HALF_OF_THE_DIGITS.
    STEP Block free(Block (&out)[7]) const {
        Block sense = 1.0;
        for (int j = 0; j < 7; ++j) out[j] = j < 6 ? 0.0 : 1.0;
#pragma GCC unroll 6
        for (int i = 5; i >= 0; --i) {
            reflect(i, out);
            sense = select(abs(r[i]) < HALF_OF_THE_DIGITS, 0.0, select(r[i] < 0.0, -sense, sense));
        }
        return sense;
    }
};

// The step of Newton's method with least norm.
template <int N> PART void least_step(const Six<Block> (&J)[7], const Block* last, const Block (&e)[7], Block (&x)[7]) {
    Reflected<N>(J, last).least(e, x);
}
PART Block tangent(const Six<Block> (&J)[7], Block (&along)[7]) { return Reflected<6>(J, nullptr).free(along); }

// The goals of points, one per lane.
STEP Goal<Block> goals_of(const Start* starts, int count) {
    bool same = true;
    for (int l = 1; l < count; ++l) same &= starts[l].T == starts[0].T;
    if (same) return spread<Block>(goal_of(starts[0].T));
    double t[12][BLOCK];
    for (int l = 0; l < BLOCK; ++l) {
        for (int i = 0; i < 12; ++i) t[i][l] = starts[l < count ? l : count - 1].T[i];
    }
    const auto column = [&](int k) { return Vec<Block>{load<Block>(t[k]), load<Block>(t[4 + k]), load<Block>(t[8 + k])}; };
    return {{column(0), column(1), column(2)}, column(3)};
}

// A block of joint vectors; from(l): the one for a lane.
template <class From> STEP void load_lanes(const Written<7>& written, const From& from, Block (&x)[7]) {
    for (int j = 0; j < 7; ++j) {
        for (int l = 0; l < BLOCK; ++l) x[j].set(l, from(l)[j]);
        x[j] = written.slides[j] ? x[j] : wrap(x[j]);
    }
}

// A block of starts: the joint vectors, which joint or whether the parameter is pinned, as ones among zeros, and the ends.
struct Starts {
    Block q[7], of_joint[7], of_parameter = 0.0, wanted, rounds, enough;
    bool pins = false;

    STEP Starts(const Written<7>& written, const Start* starts, int count) {
        for (Block& each : of_joint) each = 0.0;
        for (int l = 0; l < BLOCK; ++l) {
            const Start& from = starts[l < count ? l : count - 1];
            wanted.set(l, from.pin.value), rounds.set(l, from.rounds), enough.set(l, from.enough);
            pins |= from.pin.what != Pin::nothing;
            if (from.pin.what == Pin::joint) of_joint[from.pin.joint].set(l, 1.0);
            if (from.pin.what == Pin::parameter) of_parameter.set(l, 1.0);
        }
        load_lanes(written, [&](int l) { return starts[std::min(l, count - 1)].q; }, q);
    }
};

// Up to a block of points, side by side.
void settle_lanes(const FreeArm& arm, const Start* starts, int count, OnCurve* out) {
    const Written<7>& written = arm.written;
    const Goal<Block> goal = goals_of(starts, count);
    const Starts from(written, starts, count);
    const bool value_slides = arm.given >= 0 && written.slides[arm.given];
    const double per_unit = arm.given >= 0 ? 1.0 / arm.unit[arm.given] : 1.0;
    // The change of a joint's value as a share of its unit.
    const auto share = [&](int j, const Block& change) { return written.slides[j] ? change * (1.0 / arm.unit[j]) : wrap(change); };
    Block q[7];
    for (int j = 0; j < 7; ++j) q[j] = from.q[j];
    for (int round = 0;; ++round) {
        const Posture<7, Block> at = place(written, q);
        Six<Block> J[7];
        jacobian_at(written, at, J);
        const Error<Block> error = pose_error(goal, at.tip, 1.0 / written.size);
        const Parameter parameter = parameter_at(arm, goal, at, q);
        Block left = error.size, e[7], last[7];
        for (int i = 0; i < 6; ++i) e[i] = error.twist[i];
        if (from.pins) {
            const Block off = from.wanted - parameter.value;
            e[6] = from.of_parameter * ((value_slides ? off : wrap(off)) * per_unit);
            for (int j = 0; j < 7; ++j) {
                last[j] = from.of_parameter * per_unit * parameter.slope[j] + from.of_joint[j];
                e[6] += from.of_joint[j] * share(j, from.wanted - q[j]);
            }
            left = max(left, abs(e[6]));
        }
        const auto moves = (left > from.enough) & (from.rounds > double(round));
        if (!any(moves)) {
            Block along[7], square = 0.0;
            const Block sense = tangent(J, along), rate = inner(parameter.slope, along);
            for (int j = 0; j < 7; ++j) {
                const Block moved = share(j, q[j] - from.q[j]);
                square += moved * moved;
            }
            const Block moved = sqrt(square);
            for (int l = 0; l < count; ++l) {
                for (int j = 0; j < 7; ++j) out[l].q[j] = q[j][l], out[l].along[j] = along[j][l];
                out[l].value = parameter.value[l], out[l].rate = rate[l], out[l].moved = moved[l], out[l].left = left[l],
                out[l].sense = int(sense[l]);
            }
            return;
        }
        Block step[7];
        if (from.pins) least_step<7>(J, last, e, step);
        else least_step<6>(J, last, e, step);
        const Block length = sqrt(inner(step, step)), shrink = select(length > LONGEST_STEP, LONGEST_STEP / length, Block(1.0));
        for (int j = 0; j < 7; ++j) q[j] = select(moves, advanced(written, j, q[j], shrink * step[j]), q[j]);
    }
}

void settle(const FreeArm& arm, const Start* starts, int count, OnCurve* out) {
    for (int k = 0; k < count; k += BLOCK) settle_lanes(arm, starts + k, count - k < BLOCK ? count - k : BLOCK, out + k);
}

int search(const FreeArm& arm, const double* T, const double* starts, int count, double* q) {
    const Goal<Block> goals = spread<Block>(goal_of(T));
    std::vector<int> of(count);
    std::vector<double> error(count);
    std::copy_n(starts, 7 * count, q);
    for (int i = 0; i < count; ++i) of[i] = i;
    for (const int rounds : {SEARCH_FIRST, SEARCH_ROUNDS - SEARCH_FIRST}) {
        for (std::size_t k = 0; k < of.size(); k += BLOCK) {
            const auto start = [&](int l) { return of[std::min(k + l, of.size() - 1)]; };
            Block x[7];
            load_lanes(arm.written, [&](int l) { return q + 7 * start(l); }, x);
            const Block reached = polish<true>(arm.written, goals, x, {rounds, NEARLY_EXACT, SEARCH_PATIENCE}).error;
            for (int l = 0; l < BLOCK; ++l) {
                for (int j = 0; j < 7; ++j) q[7 * start(l) + j] = x[j][l];
                error[start(l)] = reached[l];
            }
        }
        std::erase_if(of, [&](int i) { return !(error[i] > NEARLY_EXACT); });
    }
    int many = 0;
    for (int i = 0; i < count; ++i) {
        if (error[i] <= SAME) std::copy_n(q + 7 * i, 7, q + 7 * many++);
    }
    return many;
}

void errors(const FreeArm& arm, const double* T, const double* q, long count, double* to) {
    const Goal<Block> goals = spread<Block>(goal_of(T));
    for (long k = 0; k < count; k += BLOCK) {
        Block x[7], lost = 0.0;
        load_lanes(arm.written, [&](int l) { return q + 7 * std::min(k + l, count - 1); }, x);
        for (int j = 0; j < 7; ++j) lost += 0.0 * x[j];
        const Block size = pose_error(goals, place(arm.written, x).tip, 1.0 / arm.written.size).size + lost;
        for (int l = 0; l < BLOCK && k + l < count; ++l) to[k + l] = size[l];
    }
}

}  // namespace

extern const SelfMotionFunctions self_motion_functions = {settle, search, errors};

}  // namespace urdf_ik::URDF_IK_LEVEL
