// The equations of one pose of six turning joints in numbers of many digits: those of families/general/hidden_joint.hpp, for the
// arm whose axes are moved by NUDGE.
//
// e1(q1) ... e6(q6) = G. Cut behind joint a + 1: e_a e_(a+1) moves the line of axis a + 2 to where the other joints and G put it. A
// line is fifteen numbers on which motions act linearly, so the nine products of (1, cos, sin) of joints a and a + 1 span a space
// of nine dimensions at most, and six combinations of the fifteen numbers vanish on it: six equations in the other three joints,
// linear in (1, cos, sin) of each. A line's numbers after each joint has turned by 0, pi or pi / 2 give their coefficients.
#pragma once

#include "arm/kinematics.hpp"
#include "numbers/fixed.hpp"
#include "numbers/scatter.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The axes move by about this [rad, share of the size]. An arm with a special structure then has none, its determinant does not
// vanish and its zeros are simple. A solution with the smallest singular value s moves by about NUDGE / s, and one of multiplicity
// m by about the m-th root: the rounding of doubles moves them as far.
inline constexpr double NUDGE = 1e-16;
// A bound on sums of roundings in units: matrices of 15 rows, and their factors, whose entries are sums of at most 15 products.
inline constexpr double ROUNDINGS = 1024.0;
inline constexpr int UNKNOWNS = 12, NUMBERS = 15, PRODUCTS = 9;

template <int L> struct WideMotion {
    Wide<L> R[3][3], t[3];
};
template <class V, int L> STEP Frame<V> constant_frame(const WideMotion<L>& m) {
    const auto column = [&](int k) { return Vec<V>{m.R[0][k], m.R[1][k], m.R[2][k]}; };
    return {{column(0), column(1), column(2)}, {m.t[0], m.t[1], m.t[2]}};
}
template <int L> PART Frame<Wide<L>> beyond(const Frame<Wide<L>>& at, const WideMotion<L>& m) {
    const Frame<Wide<L>> step = constant_frame<Wide<L>>(m);
    return {{at.R * step.R.x, at.R * step.R.y, at.R * step.R.z}, at.p + at.R * step.p};
}

// The motion with the rotation nearest to the stored one, which is orthogonal to 3e-14; each step squares what is left of this.
template <int L> PART WideMotion<L> wide_motion(const Motion& m, double scale) {
    using F = Fixed<L>;
    F R[3][3], next[3][3], square[3][3];
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) R[i][j] = {m.R[i][j], 0};
    }
    for (int bits = 44; bits < 64 * L; bits *= 2) {
        for (int k = 0; k < 3; ++k) {
            for (int j = k; j < 3; ++j) {
                square[k][j] = {k == j ? 3.0 : 0.0, 0};
                for (int i = 0; i < 3; ++i) square[k][j].subtract(R[i][k], R[i][j]);
                square[j][k] = square[k][j];
            }
        }
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                next[i][j] = half(R[i][0] * square[0][j] + R[i][1] * square[1][j] + R[i][2] * square[2][j]);
            }
        }
        __builtin_memcpy(R, next, sizeof next);
    }
    WideMotion<L> out;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) out.R[i][j] = R[i][j].wide();
        out.t[i] = Wide<L>(m.t[i]) * Wide<L>(scale);
    }
    return out;
}

// A direction, and a point on it.
template <class V> struct WideLine {
    Vec<V> p, d;
};
template <class V> STEP void numbers_of(const WideLine<V>& l, V (&w)[NUMBERS]) {
    const V h = half(dot(l.p, l.p)), along = dot(l.p, l.d);
    const Vec<V> m = cross(l.p, l.d), rest = h * l.d - along * l.p;
    const V all[NUMBERS] = {V(1.0), l.p.x, l.p.y, l.p.z, h, l.d.x, l.d.y, l.d.z, m.x, m.y, m.z, along, rest.x, rest.y, rest.z};
    for (int i = 0; i < NUMBERS; ++i) w[i] = all[i];
}
// v turned about the unit vector h.
template <class V> PART Vec<V> turned_about(const Vec<V>& v, const Vec<V>& h, const Turn<V>& t) {
    return t.c * v + t.s * cross(h, v) + ((V(1.0) - t.c) * dot(h, v)) * h;
}
template <class V> STEP WideLine<V> turned_about(const WideLine<V>& l, const WideLine<V>& axis, const Turn<V>& t) {
    return {axis.p + turned_about(l.p - axis.p, axis.d, t), turned_about(l.d, axis.d, t)};
}
template <class V> STEP WideLine<V> moved_by(const WideLine<V>& l, const Frame<V>& G) { return {G.R * l.p + G.p, G.R * l.d}; }

// The arm and the pose: axes at zero, moved, lengths as shares of the size, the origin in their midst, and the motion that all
// joints make together.
template <int L> struct WidePose {
    WideLine<Wide<L>> axis[6];
    Frame<Wide<L>> G;
};

template <int L> PART WidePose<L> wide_pose(const Written<6>& arm, const Frame<double>& goal) {
    using W = Wide<L>;
    WidePose<L> out;
    const double scale = 1.0 / arm.size;
    WideMotion<L> at = wide_motion<L>(arm.step[0], scale);
    Vec<double> middle = {0.0, 0.0, 0.0};
    for (int k = 0; k < 6; ++k) {
        out.axis[k] = {{at.t[0], at.t[1], at.t[2]}, {at.R[0][2], at.R[1][2], at.R[2][2]}};
        middle = middle + (1.0 / 6.0) * Vec<double>{at.t[0].leading(), at.t[1].leading(), at.t[2].leading()};
        at = composed(at, wide_motion<L>(arm.step[k + 1], scale));
    }
    const WideMotion<L> G = composed(wide_motion<L>(motion_of(goal), scale), inverse_of(at));
    out.G = constant_frame<W>(G);
    const Vec<W> centre = {middle.x, middle.y, middle.z};
    out.G.p = out.G.p + out.G.R * centre - centre;
    Scatter generic = Scatter::number(1);
    const auto moved = [&](const Vec<W>& v) {
        return Vec<W>{v.x + W(NUDGE * generic.next()), v.y + W(NUDGE * generic.next()), v.z + W(NUDGE * generic.next())};
    };
    for (auto& [p, d] : out.axis) {
        p = p - centre;
        d = moved(d);
        d = inverse_root(dot(d, d)) * d;
        p = moved(p - dot(p, d) * d);
    }
    return out;
}

// The same of the reversed chain: e6^-1 ... e1^-1 = G^-1.
template <int L> PART WidePose<L> reversed(const WidePose<L>& pose) {
    WidePose<L> out;
    const Vec<Wide<L>> zero = {0.0, 0.0, 0.0};
    for (int k = 0; k < 6; ++k) out.axis[k] = {pose.axis[5 - k].p, zero - pose.axis[5 - k].d};
    const auto& [x, y, z] = pose.G.R;
    out.G.R = {{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}};
    out.G.p = zero - out.G.R * pose.G.p;
    return out;
}

// From values at 0, pi and pi / 2 to the coefficients of 1, cos and sin.
template <class V> STEP void to_coefficients(V& a, V& b, V& c) {
    const V middle = half(a + b), cosine = half(a - b);
    a = middle, b = cosine, c = c - middle;
}

// What a triangular factorisation A = lower upper tells about A: bounds, in maximum norms, on A^-1 and on |lower| |upper|.
struct FactorBounds {
    double inverse, product;
};
// N x N doubles, row by row; lower has ones on its diagonal.
template <int N> PART FactorBounds bounds_of(const double (&a)[N][N]) {
    FactorBounds out = {0.0, 0.0};
    double y[N], z[N], row[N];
    for (int i = 0; i < N; ++i) {
        y[i] = 1.0, row[i] = 0.0;
        for (int j = 0; j < i; ++j) y[i] += abs(a[i][j]) * y[j];
        for (int j = i; j < N; ++j) row[i] += abs(a[i][j]);
        double sum = row[i];
        for (int j = 0; j < i; ++j) sum += abs(a[i][j]) * row[j];
        out.product = max(out.product, sum);
    }
    for (int i = N - 1; i >= 0; --i) {
        z[i] = y[i];
        for (int j = i + 1; j < N; ++j) z[i] += abs(a[i][j]) * z[j];
        z[i] /= abs(a[i][i]);
        out.inverse = max(out.inverse, z[i]);
    }
    return out;
}

// Joint a + 4 is measured from the angle with these sides, so that its tangent of half is neither zero nor infinite at round poses.
inline constexpr double TOO_COSINE = 3.0, TOO_SINE = 4.0;

// The equations of one cut. Their coefficients: (equation, hidden joint a + 5, joints a + 4 and a + 3, the last one fastest).
template <int L> struct WideEquations {
    using W = Wide<L>;
    WidePose<L> pose;  // of the chain, or of the reversed one
    int first;  // a
    W factor[NUMBERS][PRODUCTS];  // of the lines that joints a and a + 1 reach, rows and columns permuted
    int row[NUMBERS], column[PRODUCTS];
    Fixed<L> A[6][3][PRODUCTS];  // below one
    double error;  // of each coefficient

    STEP const WideLine<W>& axis(int k) const { return pose.axis[(first + k) % 6]; }
    // A line after the inverse turns of joints a + 3, a + 4 and a + 5, and G at its place among them.
    template <class V, class Undo> STEP WideLine<V> other_side(WideLine<V> l, const Frame<V>& G, const Undo& undo) const {
        for (int k = 0; k < 4; ++k) {
            if (k + first == 3) l = moved_by(l, G);
            if (k < 3) l = undo(k, l);
        }
        return l;
    }
};

// A line turned by 0, pi and pi / 2, or back by these.
template <class V> PART void sample_turns(const WideLine<V>& l, const WideLine<V>& axis, bool back, WideLine<V> (&out)[3]) {
    const auto turned = [&](const Vec<V>& v, Vec<V>& half_turn, Vec<V>& quarter) {
        const Vec<V> along = dot(axis.d, v) * axis.d, side = cross(axis.d, v);
        half_turn = along + along - v, quarter = back ? along - side : along + side;
    };
    out[0] = l;
    turned(l.d, out[1].d, out[2].d), turned(l.p - axis.p, out[1].p, out[2].p);
    out[1].p = out[1].p + axis.p, out[2].p = out[2].p + axis.p;
}

// Complete pivoting: factors are bounded, and the combinations hold to rounding however nearly the products depend on each other.
template <int L> PART void factorise(WideEquations<L>& of) {
    auto& a = of.factor;
    for (int i = 0; i < NUMBERS; ++i) of.row[i] = i;
    for (int j = 0; j < PRODUCTS; ++j) of.column[j] = j;
    for (int k = 0; k < PRODUCTS; ++k) {
        int r = k, c = k;
        for (int i = k; i < NUMBERS; ++i) {
            for (int j = k; j < PRODUCTS; ++j) {
                if (Wide<L>::is_less(a[r][c], a[i][j])) r = i, c = j;
            }
        }
        exchange(of.row[k], of.row[r]), exchange(of.column[k], of.column[c]);
        for (int j = 0; j < PRODUCTS; ++j) exchange(a[k][j], a[r][j]);
        for (int i = 0; i < NUMBERS; ++i) exchange(a[i][k], a[i][c]);
        if (a[k][k].is_zero()) return;
        const Wide<L> over = inverse(a[k][k]);
        for (int i = k + 1; i < NUMBERS; ++i) {
            a[i][k] = a[i][k] * over;
            for (int j = k + 1; j < PRODUCTS; ++j) a[i][j] -= a[i][k] * a[k][j];
        }
    }
}

// The lines that joints a and a + 1 reach, factorised.
template <int L> PART void set_factor(WideEquations<L>& out) {
    using W = Wide<L>;
    WideLine<W> inner[3], line[3];
    W w[NUMBERS];
    sample_turns(out.axis(2), out.axis(1), false, inner);
    for (int j = 0; j < 3; ++j) {
        sample_turns(inner[j], out.axis(0), false, line);
        for (int i = 0; i < 3; ++i) {
            numbers_of(line[i], w);
            for (int k = 0; k < NUMBERS; ++k) out.factor[k][3 * i + j] = w[k];
        }
    }
    for (auto& a : out.factor) {
        for (int i = 0; i < 3; ++i) to_coefficients(a[3 * i], a[3 * i + 1], a[3 * i + 2]);
        for (int j = 0; j < 3; ++j) to_coefficients(a[j], a[3 + j], a[6 + j]);
    }
    factorise(out);
}

// From the values at turns of the other joints to coefficients; joint a + 4 is measured from its own zero.
template <int L> PART void to_coefficients(Fixed<L> (&A)[6][3][PRODUCTS]) {
    using F = Fixed<L>;
    const Wide<L> fifth = inverse(Wide<L>(5.0));
    const F c = {Wide<L>(TOO_COSINE) * fifth, 0}, s = {Wide<L>(TOO_SINE) * fifth, 0};
    for (auto& a : A) {
        for (auto& b : a) {
            for (int i = 0; i < 3; ++i) to_coefficients(b[3 * i], b[3 * i + 1], b[3 * i + 2]);
            for (int i = 0; i < 3; ++i) {
                to_coefficients(b[i], b[3 + i], b[6 + i]);
                const F cosine = b[3 + i], sine = b[6 + i];
                b[3 + i] = c * cosine + s * sine, b[6 + i] = c * sine - s * cosine;
            }
        }
        for (int i = 0; i < PRODUCTS; ++i) to_coefficients(a[0][i], a[1][i], a[2][i]);
    }
}

// The exponent of the largest one.
template <class V> STEP int exponent_of_all(const V* x, int many) {
    int out = -1000;
    for (int i = 0; i < many; ++i) out = larger(out, exponent_of(x[i]));
    return out;
}

// The numbers of the line after the inverse turns of joints a + 5, a + 4 and a + 3 by 0, pi and pi / 2, in this order.
template <int L> PART void other_numbers(const WideEquations<L>& of, Wide<L> (&w)[27][NUMBERS]) {
    using W = Wide<L>;
    WideLine<W> one[3], two[3], three[3];
    const auto undone = [&](int k, const WideLine<W>& l, WideLine<W>(&to)[3]) {
        sample_turns(k + of.first == 3 ? moved_by(l, of.pose.G) : l, of.axis(3 + k), true, to);
    };
    undone(0, of.axis(2), one);
    for (int i = 0; i < 3; ++i) {
        undone(1, one[i], two);
        for (int j = 0; j < 3; ++j) {
            undone(2, two[j], three);
            for (int k = 0; k < 3; ++k) {
                numbers_of(of.first == 0 ? moved_by(three[k], of.pose.G) : three[k], w[9 * k + 3 * j + i]);
            }
        }
    }
}

template <int L> PART void set_equations(const WidePose<L>& pose, int first, WideEquations<L>& out) {
    using W = Wide<L>;
    out.pose = pose, out.first = first;
    set_factor(out);
    // The other rows as combinations of the first nine: C lower = other factors.
    W C[6][PRODUCTS];
    double largest = 1.0, square[PRODUCTS][PRODUCTS];
    for (int e = 0; e < 6; ++e) {
        double sum = 1.0;
        for (int k = PRODUCTS - 1; k >= 0; --k) {
            C[e][k] = out.factor[PRODUCTS + e][k];
            for (int j = k + 1; j < PRODUCTS; ++j) C[e][k] -= C[e][j] * out.factor[j][k];
            sum += abs(C[e][k].leading());
        }
        largest = max(largest, sum);
    }
    for (int i = 0; i < PRODUCTS; ++i) {
        for (int j = 0; j < PRODUCTS; ++j) square[i][j] = out.factor[i][j].leading();
    }
    const FactorBounds bounds = bounds_of(square);
    W w[27][NUMBERS];
    other_numbers(out, w);
    // All below one.
    const int of_w = larger(exponent_of_all(&w[0][0], 27 * NUMBERS), 0), of_C = larger(exponent_of_all(&C[0][0], 6 * PRODUCTS), 0);
    Fixed<L> fixed_C[6][PRODUCTS];
    for (int e = 0; e < 6; ++e) {
        for (int l = 0; l < PRODUCTS; ++l) fixed_C[e][l] = {C[e][l], of_C};
    }
    for (int k = 0; k < 27; ++k) {
        Fixed<L> v[NUMBERS];
        for (int i = 0; i < NUMBERS; ++i) v[i] = {w[k][out.row[i]], of_w};
        for (int e = 0; e < 6; ++e) {
            Fixed<L>& sum = out.A[e][k / 9][k % 9] = v[PRODUCTS + e].times_power(-of_C);
            for (int l = 0; l < PRODUCTS; ++l) sum.subtract(fixed_C[e][l], v[l]);
        }
    }
    to_coefficients(out.A);
    Fixed<L>* const first_of_A = &out.A[0][0][0];
    const int exponent = exponent_of_all(first_of_A, 6 * 27);
    for (int i = 0; i < 6 * 27; ++i) first_of_A[i] = first_of_A[i].times_power(-exponent);
    // Products are off by two units, and their sum is kept to as many digits.
    const double longest = power_of_two(of_w);
    const double error = ROUNDINGS * WIDE_UNIT<L> * longest * largest * largest * (1.0 + bounds.inverse * bounds.product);
    out.error = (error * power_of_two(-of_w - of_C) + ROUNDINGS * FIXED_UNIT<L>)*power_of_two(-exponent);
}

// The matrix at a hidden angle, by rows: the equations, polynomials of degree two in t = tan(x / 2), and t times them; columns:
// 1, t^3, t and t^2, each times (1, cos, sin) of joint a + 3. Each row has zeros in three of the first six. at(equation, i): the
// i-th coefficient there.
template <class F, class At> STEP void fill_matrix(const At& at, F (&M)[UNKNOWNS][UNKNOWNS]) {
    constexpr int place[4] = {0, 6, 9, 3};  // of 1, t, t^2, t^3
    for (int e = 0; e < 6; ++e) {
        for (int j = 0; j < 3; ++j) {
            const F f = at(e, j), g = at(e, 3 + j), h = at(e, 6 + j), part[3] = {f + g, h + h, f - g};
            M[e][place[3] + j] = M[6 + e][place[0] + j] = F{};
            for (int i = 0; i < 3; ++i) M[e][place[i] + j] = part[i], M[6 + e][place[i + 1] + j] = part[i];
        }
    }
}
// hidden: proportional to (1, cos, sin) of the hidden angle.
template <int L, class F> PART void matrix_at(const WideEquations<L>& of, const F (&hidden)[3], F (&M)[UNKNOWNS][UNKNOWNS]) {
    fill_matrix(
        [&](int e, int i) {
            using Real = typename F::Real;
            const auto& a = of.A[e];
            return hidden[0] * Real(a[0][i]) + hidden[1] * Real(a[1][i]) + hidden[2] * Real(a[2][i]);
        },
        M);
}

}  // namespace urdf_ik::URDF_IK_LEVEL
