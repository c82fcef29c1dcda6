// Points on the curve of joint vectors that hold a pose; see curve_arm.hpp. Compiled once for every instruction set.
//
// On the curve six equations in seven unknowns hold: the pose error is zero. The tangent is the null space of the Jacobian. The
// minimum-norm step of Newton's method is orthogonal to it (Allgower and Georg, Numerical Continuation Methods, chapter 3).
#include "self_motion/curve_arm.hpp"

#include <algorithm>
#include <vector>

#include "answers/answer.hpp"
#include "families/seven_joints/swivel.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

namespace {

// Longest step of Newton's method [rad, share of size].
constexpr double LONGEST_STEP = 0.5;
// A search stops after SEARCH_ROUNDS rounds, at the error SEARCH_ENOUGH, or after SEARCH_PATIENCE rounds without progress. It has
// found a point if the error is at most SEARCH_FOUND. Most starts end within SEARCH_FIRST rounds; the others go on side by side.
constexpr int SEARCH_ROUNDS = 40, SEARCH_FIRST = 5, SEARCH_PATIENCE = 14;
constexpr double SEARCH_ENOUGH = 1e-9, SEARCH_FOUND = 1e-6;

// The redundancy parameter and its gradient [per rad, per share of the size].
template <class V> struct Parameter {
    V value, slope[7];
};
// The swivel angle, computed in frame 1; see swivel.hpp.
template <class V> PART Parameter<V> swivel_at(const FreeArm& arm, const Goal<V>& goal, const Posture<7, V>& at) {
    const Line<V> line = line_to_wrist(to_frame_1<V>(goal, arm.ends).p);
    const auto of_joint = [&](int k) { return times(arm.ends.base_rotation, at.joint[k].R.z); };
    const Vec<V> axis = of_joint(3);
    const V c = dot(line.normal, axis), s = dot(line.across, axis), square = c * c + s * s + TINY;
    Parameter<V> out = {angle<V>({c, s}), {}};
    for (int k = 0; k < 7; ++k) {
        const Vec<V> turned = cross(of_joint(k), axis);
        out.slope[k] = k < 3 ? (c * dot(line.across, turned) - s * dot(line.normal, turned)) / square : V(0.0);
    }
    return out;
}
template <class V> STEP Parameter<V> parameter_at(const FreeArm& arm, const Goal<V>& goal, const Posture<7, V>& at,
                                                  const V (&q)[7]) {
    if (arm.given < 0) return swivel_at(arm, goal, at);
    Parameter<V> out = {q[arm.given], {}};
    for (int j = 0; j < 7; ++j) out.slope[j] = j == arm.given ? arm.unit[j] : 0.0;
    return out;
}

// One over a number, where a member hides inverse().
template <class V> STEP V one_over(const V& a) { return inverse(a); }

template <class V> STEP V inner(const V (&a)[7], const V (&b)[7]) {
    V sum = a[0] * b[0];
    for (int j = 1; j < 7; ++j) sum += a[j] * b[j];
    return sum;
}

// Equations (row i) x = e[i] after Gram-Schmidt orthogonalisation of the rows and right sides. `inverse` holds one over the squared
// length of each row.
template <int N, class V> struct Orthogonal {
    V row[N][7], e[N], inverse[N];

    STEP Orthogonal(const Six<V> (&J)[7], const Rows<6, V>& error, const V (&last)[7], const V& pinned) {
        for (int i = 0; i < N; ++i) {
            for (int j = 0; j < 7; ++j) row[i][j] = i < 6 ? J[j][i] : last[j];
            e[i] = i < 6 ? error[i] : pinned;
        }
#pragma GCC unroll 7
        for (int i = 0; i < N; ++i) {
            inverse[i] = one_over(inner(row[i], row[i]) + TINY);
            for (int k = i + 1; k < N; ++k) {
                const V along = inner(row[i], row[k]) * inverse[i];
                for (int j = 0; j < 7; ++j) row[k][j] -= along * row[i][j];
                e[k] -= along * e[i];
            }
        }
    }
    // The minimum-norm solution.
    STEP void least(V (&x)[7]) const {
        for (int j = 0; j < 7; ++j) x[j] = 0.0;
        for (int i = 0; i < N; ++i) {
            const V share = e[i] * inverse[i];
            for (int j = 0; j < 7; ++j) x[j] += share * row[i][j];
        }
    }
    // The unit vector orthogonal to the first six rows: the projection of the joint axis with the longest projection. It is
    // orthogonalised twice, to rounding. Returns the sign of the determinant of the rows and this vector; 0 if a row is shorter
    // than SINGULAR_ROW.
    STEP V free(V (&out)[7]) const {
        V most = -1.0;
#pragma GCC unroll 7
        for (int j = 0; j < 7; ++j) {
            V left = 1.0;
            for (int i = 0; i < 6; ++i) left -= inverse[i] * row[i][j] * row[i][j];
            const auto longer = left > most;
            most = select(longer, left, most);
            for (int k = 0; k < j; ++k) out[k] = select(longer, 0.0, out[k]);
            out[j] = select(longer, 1.0, V(0.0));
        }
        const V sign = sense(out);
        for (int again = 0; again < 2; ++again) {
            V share[6];
            for (int i = 0; i < 6; ++i) share[i] = inner(row[i], out) * inverse[i];
            for (int i = 0; i < 6; ++i) {
                for (int j = 0; j < 7; ++j) out[j] -= share[i] * row[i][j];
            }
        }
        const V scale = inverse_sqrt(inner(out, out) + TINY);
        for (int j = 0; j < 7; ++j) out[j] *= scale;
        return sign;
    }
    // The sign of the determinant of the first six rows and a unit axis: of the other columns, by elimination.
    STEP V sense(const V (&axis)[7]) const {
        V rows[6][6], sign = 1.0;
        // A row that is shorter than HALF_OF_THE_DIGITS after orthogonalisation cannot be distinguished from rounding.
        for (int i = 0; i < 6; ++i) sign = select(inverse[i] > 1.0 / (HALF_OF_THE_DIGITS * HALF_OF_THE_DIGITS), 0.0, sign);
        // The last column takes the place of the axis' column; exchanging two columns flips the sign.
        sign = select(axis[6] > 0.5, sign, -sign);
#pragma GCC unroll 6
        for (int j = 0; j < 6; ++j) {
            const auto here = axis[j] > 0.5;
            for (int i = 0; i < 6; ++i) rows[i][j] = select(here, row[i][6], row[i][j]);
        }
#pragma GCC unroll 6
        for (int i = 0; i < 6; ++i) {
            // The longest entry becomes the pivot.
#pragma GCC unroll 6
            for (int j = i + 1; j < 6; ++j) {
                const auto longer = abs(rows[i][j]) > abs(rows[i][i]);
                sign = select(longer, -sign, sign);
#pragma GCC unroll 6
                for (int k = i; k < 6; ++k) {
                    const V one = rows[k][i], other = rows[k][j];
                    rows[k][i] = select(longer, other, one), rows[k][j] = select(longer, one, other);
                }
            }
            sign = select(rows[i][i] < 0.0, -sign, sign);
            const V over = one_over(rows[i][i]);
#pragma GCC unroll 6
            for (int k = i + 1; k < 6; ++k) {
                const V share = rows[k][i] * over;
#pragma GCC unroll 6
                for (int j = i + 1; j < 6; ++j) rows[k][j] -= share * rows[i][j];
            }
        }
        return sign;
    }
};

// The step of Newton's method with least norm.
template <int N, class V>
PART void least_step(const Six<V> (&J)[7], const Rows<6, V>& error, const V (&last)[7], const V& apart, V (&x)[7]) {
    Orthogonal<N, V>(J, error, last, apart).least(x);
}
template <class V> PART V tangent(const Six<V> (&J)[7], const Rows<6, V>& error, V (&along)[7]) {
    const V none[7] = {};
    const Orthogonal<6, V> rows(J, error, none, V(0.0));
    return rows.free(along);
}

// A number or a pack from numbers in memory, and back.
template <class V> STEP V from_lanes(const double* from) {
    if constexpr (lanes_of<V> == 1) return *from;
    else return load<V>(from);
}
template <class V> STEP void to_lanes(const V& a, double* to) {
    if constexpr (lanes_of<V> == 1) *to = a;
    else store(a, to);
}

// The goals of points, one per lane.
template <class V> STEP Goal<V> goals_of(const Start* starts, int count) {
    const Goal<double> first = goal_of(starts[0].T);
    if constexpr (lanes_of<V> == 1) return first;
    else {
        bool same = true;
        for (int l = 1; l < count; ++l) same &= starts[l].T == starts[0].T;
        if (same) return spread<V>(first);
        double t[12][lanes_of<V>];
        for (int l = 0; l < lanes_of<V>; ++l) {
            const double* T = starts[l < count ? l : count - 1].T;
            for (int i = 0; i < 12; ++i) t[i][l] = T[i];
        }
        const auto column = [&](int k) { return Vec<V>{from_lanes<V>(t[k]), from_lanes<V>(t[4 + k]), from_lanes<V>(t[8 + k])}; };
        return {{column(0), column(1), column(2)}, column(3)};
    }
}

// Up to a V's number of lanes of points, side by side.
template <class V> void settle_lanes(const FreeArm& arm, const Start* starts, int count, OnCurve* out) {
    constexpr int LANES = lanes_of<V>;
    const Written<7>& written = arm.written;
    const Goal<V> goal = goals_of<V>(starts, count);
    // By lanes; which joint or whether the parameter is pinned, as ones among zeros.
    double lanes[7][LANES], pin_value[LANES], pin_joint[7][LANES] = {}, pin_parameter[LANES] = {}, ends[2][LANES];
    bool pins = false;
    for (int l = 0; l < LANES; ++l) {
        const Start& from = starts[l < count ? l : count - 1];
        for (int j = 0; j < 7; ++j) lanes[j][l] = from.q[j];
        pin_value[l] = from.pin.value;
        ends[0][l] = from.rounds, ends[1][l] = from.enough;
        pins |= from.pin.what != Pin::nothing;
        if (from.pin.what == Pin::joint) pin_joint[from.pin.joint][l] = 1.0;
        if (from.pin.what == Pin::parameter) pin_parameter[l] = 1.0;
    }
    V q[7], start[7], of_joint[7];
    const V wanted = from_lanes<V>(pin_value), of_parameter = from_lanes<V>(pin_parameter);
    const V rounds = from_lanes<V>(ends[0]), enough = from_lanes<V>(ends[1]);
    for (int j = 0; j < 7; ++j) {
        q[j] = from_lanes<V>(lanes[j]), of_joint[j] = from_lanes<V>(pin_joint[j]);
        start[j] = q[j] = written.slides[j] ? q[j] : wrap(q[j]);
    }
    const bool value_slides = arm.given >= 0 && written.slides[arm.given];
    const double value_unit = arm.given >= 0 ? arm.unit[arm.given] : 1.0;
    for (int round = 0;; ++round) {
        const Posture<7, V> at = place(written, q);
        Six<V> J[7];
        jacobian_at(written, at, J);
        const Error<V> error = pose_error(goal, at.tip, 1.0 / written.size);
        const Parameter<V> parameter = parameter_at(arm, goal, at, q);
        V left = error.size, apart = 0.0, last[7];
        if (pins) {
            const V off = wanted - parameter.value;
            apart = of_parameter * ((value_slides ? off : wrap(off)) * (1.0 / value_unit));
            for (int j = 0; j < 7; ++j) {
                last[j] = of_parameter * (1.0 / value_unit) * parameter.slope[j] + of_joint[j];
                const V gap = wanted - q[j];
                apart += of_joint[j] * (written.slides[j] ? gap * (1.0 / arm.unit[j]) : wrap(gap));
            }
            left = max(left, abs(apart));
        }
        const auto moves = (left > enough) & (rounds > double(round));
        if (!any(moves)) {
            V along[7], square = 0.0;
            const V sense = tangent(J, error.twist, along), rate = inner(parameter.slope, along);
            for (int j = 0; j < 7; ++j) {
                const V moved = q[j] - start[j], share = written.slides[j] ? moved * (1.0 / arm.unit[j]) : wrap(moved);
                square += share * share;
            }
            double tangents[7][LANES], values[LANES], rates[LANES], way[LANES], errors[LANES], senses[LANES];
            for (int j = 0; j < 7; ++j) to_lanes(q[j], lanes[j]), to_lanes(along[j], tangents[j]);
            to_lanes(parameter.value, values), to_lanes(rate, rates), to_lanes(sqrt(square), way), to_lanes(left, errors),
                to_lanes(sense, senses);
            for (int l = 0; l < count; ++l) {
                OnCurve& to = out[l];
                for (int j = 0; j < 7; ++j) to.q[j] = lanes[j][l], to.along[j] = tangents[j][l];
                to.value = values[l], to.rate = rates[l], to.moved = way[l], to.left = errors[l], to.sense = int(senses[l]);
            }
            return;
        }
        V step[7];
        if (pins) least_step<7, V>(J, error.twist, last, apart, step);
        else least_step<6, V>(J, error.twist, last, apart, step);
        const V length = sqrt(inner(step, step)), shrink = select(length > LONGEST_STEP, LONGEST_STEP / length, V(1.0));
        for (int j = 0; j < 7; ++j) q[j] = select(moves, advanced(written, j, q[j], shrink * step[j]), q[j]);
    }
}

void settle(const FreeArm& arm, const Start* starts, int count, OnCurve* out) {
    for (int k = 0; k < count;) {
        const int many = count - k < BLOCK ? count - k : BLOCK;
        if (many > 1) {
            settle_lanes<Block>(arm, starts + k, many, out + k);
            k += many;
        } else {
            settle_lanes<double>(arm, starts + k, 1, out + k);
            ++k;
        }
    }
}

// Newton's method from starts (count, 7), with the numbers `of` (count); each is replaced by what it reaches. error: (count).
void search_from(const Written<7>& written, const Goal<Block>& goals, const int* of, int count, int rounds, double* q,
                 double* error) {
    for (int k = 0; k < count; k += BLOCK) {
        const int many = count - k < BLOCK ? count - k : BLOCK;
        Block x[7];
        for (int l = 0; l < BLOCK; ++l) {
            const double* from = q + 7 * of[k + (l < many ? l : many - 1)];
            for (int j = 0; j < 7; ++j) x[j].set(l, written.slides[j] ? from[j] : wrap(from[j]));
        }
        const Block reached = polish<true>(written, goals, x, {rounds, SEARCH_ENOUGH, SEARCH_PATIENCE}).error;
        for (int l = 0; l < many; ++l) {
            const int i = of[k + l];
            for (int j = 0; j < 7; ++j) q[7 * i + j] = x[j][l];
            error[i] = reached[l];
        }
    }
}

int search(const FreeArm& arm, const double* T, const double* starts, int count, double* q) {
    const Goal<Block> goals = spread<Block>(goal_of(T));
    std::vector<int> of(count);
    std::vector<double> error(count);
    std::copy_n(starts, 7 * count, q);
    for (int i = 0; i < count; ++i) of[i] = i;
    search_from(arm.written, goals, of.data(), count, SEARCH_FIRST, q, error.data());
    std::erase_if(of, [&](int i) { return !(error[i] > SEARCH_ENOUGH); });
    search_from(arm.written, goals, of.data(), int(of.size()), SEARCH_ROUNDS - SEARCH_FIRST, q, error.data());
    int many = 0;
    for (int i = 0; i < count; ++i) {
        if (!(error[i] <= SEARCH_FOUND)) continue;
        std::copy_n(q + 7 * i, 7, q + 7 * many);
        ++many;
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
