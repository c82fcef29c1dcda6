// See on_curve.hpp. Compiled once for every instruction set.
#include "referee/on_curve.hpp"

#include "certify/svd.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Steps along a curve of solutions to either side, and their length [rad].
inline constexpr int STEPS_ALONG_CURVE = 3;
inline constexpr double ALONG_CURVE = 0.02;

// A form counts as zero below ZERO_FORM: solutions where ranks are lost are known to half of their digits.
inline constexpr double ZERO_FORM = 1e-6;
inline constexpr int ROUNDS_TO_ZERO = 12;

// Directions in which a curve may leave a solution at which the Jacobian loses ranks.
struct CurveDirections {
    static constexpr int most = 16;
    double direction[most][6];
    int many = 0;

    // Adds a unit vector unless it, or its opposite, is there.
    STEP void add(const double (&d)[6]) {
        for (int i = 0; i < many; ++i) {
            if (abs(inner_product(d, direction[i])) > 0.999 || many == most) return;
        }
        for (int j = 0; j < 6; ++j) direction[many][j] = d[j];
        ++many;
    }
};

// The columns of a matrix with these columns, or rows.
STEP void columns_of(const Six<double> (&twist)[6], bool rows, double (&out)[6][6]) {
    for (int k = 0; k < 6; ++k) {
        for (int i = 0; i < 6; ++i) out[k][i] = rows ? twist[i][k] : twist[k][i];
    }
}

// The second derivatives Q_o along the lost directions: a curve's tangent t satisfies t' Q_o t = 0 for each lost row o.
template <int R> struct LostForms {
    double Q[R][R][R];

    STEP void at(const double (&t)[R], double (&value)[R], double (&slope)[R][R]) const {
        for (int o = 0; o < R; ++o) {
            value[o] = 0.0;
            for (int a = 0; a < R; ++a) {
                slope[o][a] = 0.0;
                for (int b = 0; b < R; ++b) slope[o][a] += Q[o][a][b] * t[b];
                value[o] += 0.5 * slope[o][a] * t[a];
            }
        }
    }
};
template <int R> PART LostForms<R> lost_forms(const Six<double> (&twist)[6], const Svd<6, 6>& J) {
    LostForms<R> out = {};
    double columns[6][6];
    Svd<6, 6> back;
    columns_of(twist, true, columns);
    svd(columns, back);
    for (int i = 0; i < 6; ++i) {
        for (int j = i; j < 6; ++j) {
            const Six<double> each = second_derivative(twist[i], twist[j]);
            for (int o = 0; o < R; ++o) {
                double f = 0.0;
                for (int k = 0; k < 6; ++k) f += back.right[6 - R + o][k] * each[k];
                for (int x = 0; x < R; ++x) {
                    for (int y = 0; y < R; ++y) {
                        const auto &p = J.right[6 - R + x], &q = J.right[6 - R + y];
                        out.Q[o][x][y] += f * (i == j ? p[i] * q[i] : p[i] * q[j] + p[j] * q[i]);
                    }
                }
            }
        }
    }
    return out;
}

// Adds the directions in which all these forms vanish: the method of Gauss and Newton on the unit sphere, from the middles of the
// faces, edges and corners of half a cube.
template <int R> PART void add_zeros(const Six<double> (&twist)[6], const Svd<6, 6>& J, CurveDirections& out) {
    const LostForms<R> forms = lost_forms<R>(twist, J);
    for (int start = 0; start < (R == 2 ? 4 : 13); ++start) {
        double t[R], value[R], slope[R][R], left = 0.0;
        // Coordinates are base-3 digits, less one. Codes from 5 (R = 2) or 14 (R = 3) on are one of each pair of opposite points.
        for (int a = 0, code = start + (R == 2 ? 5 : 14); a < R; ++a, code /= 3) t[a] = code % 3 - 1;
        for (int round = 0;; ++round) {
            const double length = length_of(t);
            for (double& each : t) each /= length;
            forms.at(t, value, slope);
            left = 0.0;
            for (const double each : value) left = max(left, abs(each));
            if (round == ROUNDS_TO_ZERO || left < ZERO_FORM) break;
            // t itself is the last row, so that the step stays across it.
            double columns[R][R + 1], right[R + 1] = {};
            for (int o = 0; o < R; ++o) {
                for (int a = 0; a < R; ++a) columns[a][o] = slope[o][a];
                right[o] = -value[o];
            }
            for (int a = 0; a < R; ++a) columns[a][R] = t[a];
            Svd<R + 1, R> found;
            svd(columns, found);
            for (int k = 0; k < R; ++k) {
                if (!(found.s[k] > ZERO_FORM)) continue;
                const double along = inner_product(found.image[k], right) / (found.s[k] * found.s[k]);
                for (int a = 0; a < R; ++a) t[a] += along * found.right[k][a];
            }
        }
        if (!(left < ZERO_FORM)) continue;
        double d[6] = {};
        for (int a = 0; a < R; ++a) {
            for (int j = 0; j < 6; ++j) d[j] += t[a] * J.right[6 - R + a][j];
        }
        out.add(d);
    }
}

PART CurveDirections curve_directions(const Written<6>& arm, const Goal<double>& goal, const double (&q)[6]) {
    Six<double> twist[6];
    derivatives_at(arm, goal, q, twist);
    double columns[6][6];
    columns_of(twist, false, columns);
    Svd<6, 6> J;
    svd(columns, J);
    CurveDirections out;
    if (J.s[5] > arm.tolerances.singular) return out;
    if (J.s[4] > LOST_RANK) out.add(J.right[5]);
    else if (J.s[3] > LOST_RANK) add_zeros<2>(twist, J, out);
    else add_zeros<3>(twist, J, out);
    return out;
}

// Whether Newton's method from points along the direction, each farther away, ends beside them, and keeps the pose to the
// tolerance of solutions.
PART bool follows_curve(const Written<6>& arm, const Goal<double>& goal, const double (&q)[6], const double (&direction)[6]) {
    for (int k = 1; k <= STEPS_ALONG_CURVE; ++k) {
        for (int sign = -1; sign <= 1; sign += 2) {
            double at[6], away = 0.0;
            for (int j = 0; j < 6; ++j) at[j] = q[j];
            if (!(move_along(arm, goal, ACROSS_A_VALLEY, sign * k * ALONG_CURVE, direction, at) <= arm.tolerances.reach))
                return false;
            for (int j = 0; j < 6; ++j) away += sign * direction[j] * wrap(at[j] - q[j]);
            if (!(away > 0.7 * k * ALONG_CURVE && away < 1.3 * k * ALONG_CURVE)) return false;
        }
    }
    return true;
}

bool is_on_curve(const Written<6>& arm, const Goal<double>& goal, const double (&q)[6]) {
    if (weakest_at(arm, goal, q).value > arm.tolerances.singular) return false;
    const CurveDirections along = curve_directions(arm, goal, q);
    for (int i = 0; i < along.many; ++i) {
        if (follows_curve(arm, goal, q, along.direction[i])) return true;
    }
    return false;
}

bool any_is_on_curve(const Written<6>& arm, const Goal<double>& goal, const Columns<6>& columns) {
    for (int b = 0; b < columns.many; ++b) {
        if (columns.valid(b) && columns.flags[b] & SINGULAR && is_on_curve(arm, goal, columns.row(b))) return true;
    }
    return false;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
