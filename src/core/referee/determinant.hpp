// The determinant of the equations (equations.hpp) as a polynomial in the tangent of half the hidden angle, its sixteen roots, and
// the other joints at each.
#pragma once

#include "certify/circle.hpp"
#include "numbers/polynomials.hpp"
#include "referee/equations.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

inline constexpr int HARMONIC = 8, ROOTS = 16, WIDE_SAMPLES = 17;

// A real polynomial in x = tan((angle - centre) / 2). error: of its value, as a share of (1 + |x|)^16.
template <int L> struct HalfTangent {
    Fixed<L> a[ROOTS + 1];  // below one
    Turn<Wide<L>> centre;
    double error;
    Complex rounded[ROOTS + 1];  // in e^(i angle), in doubles
};

// e^(2 pi i k / 17): Newton's method from doubles.
template <int L> struct Seventeenths {
    WideComplex<L> at[WIDE_SAMPLES];
    Seventeenths() {
        const Turn<double> start = cos_sin(2.0 * PI / WIDE_SAMPLES);
        WideComplex<L> z = {start.c, start.s};
        const WideComplex<L> seventeenth = inverse(WideComplex<L>(double(WIDE_SAMPLES)));
        for (int bits = 50; bits < 64 * L; bits *= 2) {
            WideComplex<L> p = z;
            for (int k = 0; k < 4; ++k) p = p * p;  // z^16
            z -= seventeenth * (z - inverse(p));
        }
        at[0] = 1.0;
        for (int k = 1; k < WIDE_SAMPLES; ++k) at[k] = at[k - 1] * z;
    }
};

// The determinant by elimination with row pivots, and a bound on its error: with M^-1 and the change E of M in maximum norms,
// det(M + E) = det M det(1 + M^-1 E), and |det(1 + X) - 1| <= (1 + |X|)^12 - 1. `off`: of each entry. Infinite where it vanishes.
// Entries are below 6, and each pivot doubles them at most. A factor's rounding, times its pivot, is a few units.
template <int L> PART Wide<L> determinant(Fixed<L> (&M)[UNKNOWNS][UNKNOWNS], double off, double& error) {
    using F = Fixed<L>;
    Wide<L> product = 1.0;
    error = __builtin_inf();
    double rounded[UNKNOWNS][UNKNOWNS] = {};
    for (int k = 0; k < UNKNOWNS; ++k) {
        int r = k;
        for (int i = k + 1; i < UNKNOWNS; ++i) {
            if (F::is_less(M[r][k], M[i][k])) r = i;
        }
        Wide<L> pivot = M[r][k].wide();
        if (pivot.is_zero()) return 0.0;
        product = product * pivot;
        if (r != k) {
            product = -product;
            for (int j = 0; j < UNKNOWNS; ++j) exchange(M[k][j], M[r][j]), exchange(rounded[k][j], rounded[r][j]);
        }
        for (int j = k; j < UNKNOWNS; ++j) rounded[k][j] = M[k][j].leading();
        const int exponent = pivot.exponent;
        pivot.exponent = 0;
        const F over = inverse(F(pivot, 0));
        for (int i = k + 1; i < UNKNOWNS; ++i) {
            if (M[i][k].is_zero()) continue;
            const F f = over * M[i][k].times_power(-exponent);
            rounded[i][k] = f.leading();
            for (int j = k + 1; j < UNKNOWNS; ++j) {
                if (!M[k][j].is_zero()) M[i][j].subtract(f, M[k][j]);
            }
        }
    }
    const FactorBounds bounds = bounds_of(rounded);
    const double x = bounds.inverse * (UNKNOWNS * off + ROUNDINGS * FIXED_UNIT<L> * (1.0 + bounds.product));
    if (x < 0.01) error = 14.0 * x * abs(product.leading());
    return product;
}

// Seventeen samples of the determinant, to coefficients. Returns whether it is known at all.
template <int L> PART bool half_tangent_polynomial(const WideEquations<L>& of, HalfTangent<L>& out) {
    using W = Wide<L>;
    const Seventeenths<L> wave;
    W D[WIDE_SAMPLES], re[HARMONIC + 1], im[HARMONIC + 1];
    int largest = 0;
    double lost = 0.0;
    for (int k = 0; k <= HARMONIC; ++k) {
        // Opposite angles share their products.
        const Fixed<L> c = {wave.at[k].re, 0}, s = {wave.at[k].im, 0};
        Fixed<L> even[6][PRODUCTS], odd[6][PRODUCTS];
        for (int e = 0; e < 6; ++e) {
            for (int i = 0; i < PRODUCTS; ++i) even[e][i] = of.A[e][0][i] + c * of.A[e][1][i], odd[e][i] = s * of.A[e][2][i];
        }
        for (int opposite = 0; opposite < (k ? 2 : 1); ++opposite) {
            const int sample = opposite ? WIDE_SAMPLES - k : k;
            Fixed<L> M[UNKNOWNS][UNKNOWNS];
            double error;
            fill_matrix([&](int e, int i) { return opposite ? even[e][i] - odd[e][i] : even[e][i] + odd[e][i]; }, M);
            D[sample] = determinant(M, 3.0 * of.error, error);
            if (!(error < __builtin_inf())) return false;
            lost += error;
        }
    }
    for (int k = 1; k < WIDE_SAMPLES; ++k) {
        if (W::is_less(D[largest], D[k])) largest = k;
    }
    // To numbers of order one.
    const int exponent = D[largest].exponent;
    const double scale = power_of_two(-exponent);
    for (W& each : D) each.exponent -= exponent;
    out.error = 17.0 * (scale * lost + ROUNDINGS * WIDE_UNIT<L>);
    for (int h = 0; h <= HARMONIC; ++h) {
        re[h] = im[h] = 0.0;
        for (int k = 0; k < WIDE_SAMPLES; ++k) {
            const WideComplex<L>& w = wave.at[h * k % WIDE_SAMPLES];
            re[h] += D[k] * w.re, im[h] -= D[k] * w.im;
        }
        out.rounded[HARMONIC + h] = {re[h].leading(), im[h].leading()};
        out.rounded[HARMONIC - h] = {re[h].leading(), -im[h].leading()};
    }
    // The centre is opposite to the largest sample: no root is far out.
    const WideComplex<L> turn = WideComplex<L>(0.0) - wave.at[largest];
    out.centre = {turn.re, turn.im};
    WideComplex<L> power = 1.0;
    W a[ROOTS + 1];
    for (int j = 0; j <= ROOTS; ++j) {
        a[j] = 0.0;
        if (j % 2 == 0) a[j] = W(j % 4 ? -KRAWTCHOUK.at[8][j] : KRAWTCHOUK.at[8][j]) * re[0];
    }
    for (int k = 1; k <= HARMONIC; ++k) {
        power = power * turn;
        const WideComplex<L> c = W(2.0) * (power * WideComplex<L>(re[k], im[k]));
        const W part[4] = {c.re, -c.im, -c.re, c.im};
        for (int j = 0; j <= ROOTS; ++j) a[j] += W(KRAWTCHOUK.at[8 + k][j]) * part[j % 4];
    }
    int most = -1000;
    for (const W& each : a) most = larger(most, exponent_of(each));
    for (int j = 0; j <= ROOTS; ++j) out.a[j] = {a[j], most};
    out.error = 17.0 * (scale * lost + ROUNDINGS * WIDE_UNIT<L>)*power_of_two(-most) + ROUNDINGS * FIXED_UNIT<L>;
    return true;
}

// A root and its disc. Discs that meet form a group, which holds as many roots as it has discs.
template <int L> struct WideRoot {
    WideComplex<L> x;
    double radius;
    int together;  // discs in its group
    double least;  // distance of the disc from the real axis, as an imaginary part of the angle
};

STEP double size_of(const Complex& a) { return sqrt(a.re * a.re + a.im * a.im); }
template <int L> STEP Complex leading(const WideComplex<L>& a) { return {a.re.leading(), a.im.leading()}; }

// p(x) as a share of |x|^16 where |x| > 1, in size; and Newton's step. By division by (t - x) (t - conj(x)), twice, with real
// numbers alone; where |x| > 1 the polynomial in 1 / x.
template <int L> PART void value_at(const HalfTangent<L>& p, const WideComplex<L>& x, double& size, Complex& newton) {
    using F = Fixed<L>;
    const Complex at = leading(x);
    const bool far = at.re * at.re + at.im * at.im > 1.0;
    const WideComplex<L> in = far ? inverse(x) : x;
    const F re = {in.re, 0}, im = {in.im, 0}, r = re + re, s = re * re + im * im;
    F b[2] = {}, c[2] = {};  // the last two of p's quotient and of the quotient's own
    for (int k = ROOTS; k >= 0; --k) {
        const F next = p.a[far ? ROOTS - k : k] + r * b[0] - s * b[1];
        b[1] = b[0], b[0] = next;
        if (k < 2) continue;
        const F other = next + r * c[0] - s * c[1];
        c[1] = c[0], c[0] = other;
    }
    const auto rounded = [](const F& re, const F& im) { return Complex{re.wide().leading(), im.wide().leading()}; };
    const Complex value = rounded(b[0] - b[1] * re, b[1] * im);
    const F twice = im + im;
    const Complex slope = rounded(b[1] - twice * (c[1] * im), twice * (c[0] - c[1] * re));
    size = size_of(value);
    newton = far ? at * (at * value) * inverse(double(ROOTS) * (at * value) - slope) : value * inverse(slope);
}

// Rounds of Aberth's iteration; each adds the digits of doubles once a root stands apart from the others. A root is known well
// enough when a step is below this share of the distance from the nearest one.
inline constexpr int ROUNDS_TO_ROOTS = 80;
inline constexpr double ROUGHLY = 1e-13, NEAR_REAL = 0.01;

// How far from real an angle is whose half has the tangent x, or twice as much where it is far.
STEP double imaginary_part(const Complex& x, double im) { return 2.0 * abs(im) / (1.0 + x.re * x.re + x.im * x.im); }

template <int L> PART void start_roots(const HalfTangent<L>& p, WideRoot<L> (&root)[ROOTS]) {
    Complex z[ROOTS];
    self_inversive_roots<ROOTS>(p.rounded, z);
    const double c = p.centre.c.leading(), s = p.centre.s.leading();
    for (int i = 0; i < ROOTS; ++i) {
        // x = -i (w - 1) / (w + 1), w = z / e^(i centre)
        const Complex w = {z[i].re * c + z[i].im * s, z[i].im * c - z[i].re * s};
        const Complex x = Complex(w.im, 1.0 - w.re) * inverse(Complex(w.re + 1.0, w.im));
        const bool good = size_of(x) < 1e6;
        root[i].x = {good ? x.re : 0.01 * i, good ? x.im : (i % 2 ? 0.9 : -0.9)};
    }
}

// Roots that lie within this share of each other's unit are told apart in a smaller unit, up to so many times.
inline constexpr double BESIDE_IN_DOUBLES = 0.01;
inline constexpr int SMALLER_UNITS = 6, ROUNDS_IN_DOUBLES = 24;

// The `many` roots y of sum c_k y^k that are not far beyond 1: Aberth's iteration.
PART void roots_in_doubles(const Complex (&c)[ROOTS + 1], int many, Complex* y) {
    for (int i = 0; i < many; ++i) {
        const Turn<double> t = cos_sin(0.4 + 2.0 * PI * i / many - PI);
        y[i] = {0.8 * t.c, 0.8 * t.s};
    }
    bool moves = true;
    for (int round = 0; round < ROUNDS_IN_DOUBLES && moves; ++round) {
        moves = false;
        for (int i = 0; i < many; ++i) {
            Complex value = c[ROOTS], slope = 0.0, sum = 0.0;
            for (int k = ROOTS - 1; k >= 0; --k) slope = slope * y[i] + value, value = value * y[i] + c[k];
            if (value.re == 0.0 && value.im == 0.0) continue;
            for (int j = 0; j < many; ++j) {
                if (j != i) sum += inverse(y[i] - y[j]);
            }
            const Complex step = value * inverse(slope - value * sum);
            if (!(size_of(step) < 10.0)) continue;
            y[i] = y[i] - step, moves |= size_of(step) > 1e-12;
        }
    }
}

template <int L>
void separate_all(const HalfTangent<L>& p, WideRoot<L>* const* at, const Complex* y, int many, bool far, double unit, int times);

// Roots that doubles do not tell apart: the polynomial is shifted to their mean and scaled, so that they are of size one, and
// solved in doubles. far: the roots are those in 1 / x. unit: the scale before.
template <int L> PART void separate(const HalfTangent<L>& p, WideRoot<L>* const* at, int many, bool far, double unit, int times) {
    WideComplex<L> middle = 0.0;
    double spread = 0.0;
    for (int i = 0; i < many; ++i) middle += at[i]->x;
    middle = inverse(Wide<L>(double(many))) * middle;
    for (int i = 0; i < many; ++i) spread = max(spread, size_of(leading(at[i]->x - middle)));
    Complex t[ROOTS + 1];
    const auto shift = [&](auto& b, const auto& c) {
        for (int j = 0; j <= ROOTS; ++j) {
            for (int k = ROOTS - 1; k >= j; --k) b[k] = b[k] + c * b[k + 1];
        }
    };
    // Among real roots and pairs the middle is real.
    if (abs(middle.im.leading()) < spread) {
        Fixed<L> b[ROOTS + 1];
        middle.im = 0.0;
        for (int k = 0; k <= ROOTS; ++k) b[k] = p.a[far ? ROOTS - k : k];
        shift(b, Fixed<L>(middle.re, 0));
        for (int k = 0; k <= ROOTS; ++k) t[k] = b[k].leading();
    } else {
        FixedComplex<L> b[ROOTS + 1];
        for (int k = 0; k <= ROOTS; ++k) b[k] = {p.a[far ? ROOTS - k : k], Fixed<L>{}};
        shift(b, FixedComplex<L>(middle, 0));
        for (int k = 0; k <= ROOTS; ++k) t[k] = {b[k].re.leading(), b[k].im.leading()};
    }
    double own = 0.0;
    // The largest root is at most about twice as large (Fujiwara 1916).
    for (int j = 0; j < many; ++j) {
        const double share = size_of(t[j]) / size_of(t[many]);
        if (share > 0.0) own = max(own, exponential(logarithm(share) / (many - j)));
    }
    if (!(own > 0.0 && own < unit)) return;
    double power = 1.0 / size_of(t[many]);
    for (int j = many; j > 0; --j) power /= own;
    for (int j = 0; j <= ROOTS; ++j, power *= own) t[j] = {power * t[j].re, power * t[j].im};
    Complex y[ROOTS];
    roots_in_doubles(t, many, y);
    for (int i = 0; i < many; ++i) at[i]->x = middle + WideComplex<L>(own * y[i].re, own * y[i].im);
    if (times) separate_all(p, at, y, many, far, own, times - 1);
}

STEP bool are_beside(const Complex& a, const Complex& b) {
    const auto length = [](const Complex& x) { return 1.0 + x.re * x.re + x.im * x.im; };
    const double apart = size_of(a - b);
    return apart * apart < BESIDE_IN_DOUBLES * BESIDE_IN_DOUBLES * length(a) * length(b);
}

// The same for each group that doubles do not tell apart among the roots unit y; at the first call the unit is 0, and y are the
// roots.
template <int L> PART void separate_all(const HalfTangent<L>& p, WideRoot<L>* const* at, const Complex* y, int many, bool far,
                                        double unit, int times) {
    unsigned left = (1u << many) - 1;
    while (left) {
        unsigned group = left & -left;
        for (bool grows = true; grows;) {
            grows = false;
            for (int j = 0; j < many; ++j) {
                for (int i = 0; i < many && (left & ~group) >> j & 1; ++i) {
                    if (group >> i & 1 && are_beside(y[i], y[j])) group |= 1u << j, grows = true;
                }
            }
        }
        left &= ~group;
        WideRoot<L>* together[ROOTS];
        int n = 0;
        for (int i = 0; i < many; ++i) {
            if (group >> i & 1) together[n++] = at[i];
        }
        if (n == 1) continue;
        const bool first = unit == 0.0, turned = first && size_of(leading(together[0]->x)) > 1.0;
        for (int i = 0; i < n && turned; ++i) together[i]->x = inverse(together[i]->x);
        separate(p, together, n, first ? turned : far, first ? 1.0 : unit, times);
        for (int i = 0; i < n && turned; ++i) together[i]->x = inverse(together[i]->x);
    }
}

// The roots that doubles do not tell apart.
template <int L> PART void separate_roots(const HalfTangent<L>& p, WideRoot<L> (&root)[ROOTS]) {
    WideRoot<L>* at[ROOTS];
    Complex y[ROOTS];
    for (int i = 0; i < ROOTS; ++i) at[i] = root + i, y[i] = leading(root[i].x);
    separate_all(p, at, y, ROOTS, false, 0.0, SMALLER_UNITS);
}

template <int L> PART void improve_roots(const HalfTangent<L>& p, WideRoot<L> (&root)[ROOTS]) {
    unsigned moves = (1u << ROOTS) - 1;
    for (int round = 0; round < ROUNDS_TO_ROOTS && moves; ++round) {
        for (int i = 0; i < ROOTS; ++i) {
            if (!(moves >> i & 1)) continue;
            Complex newton, sum = {0.0, 0.0};
            double value, nearest = 1.0;
            value_at(p, root[i].x, value, newton);
            const Complex at = leading(root[i].x);
            const double size = 1.0 + size_of(at);
            if (!(value > ROUNDINGS * FIXED_UNIT<L>)) {
                moves &= ~(1u << i);
                continue;
            }
            for (int j = 0; j < ROOTS; ++j) {
                const Complex apart = leading(root[i].x - root[j].x);
                if (j == i || (apart.re == 0.0 && apart.im == 0.0)) continue;
                sum += inverse(apart), nearest = min(nearest, size_of(apart));
            }
            const Complex step = newton * inverse(Complex(1.0) - newton * sum);
            if (!(size_of(step) < 1e3)) {
                root[i].x += WideComplex<L>(0.01 * size, 0.013 * size);
                continue;
            }
            root[i].x -= WideComplex<L>(step.re, step.im);
            if (size_of(step) < ROUGHLY * nearest) moves &= ~(1u << i);
        }
    }
}

// The other joints take fewer digits than the hidden one.
inline constexpr int JOINT_LIMBS = 3;

// The digits that they take, of a root that stands apart.
template <int L> PART void refine(const HalfTangent<L>& p, WideComplex<L>& x) {
    for (int bits = 60; bits < 64 * JOINT_LIMBS; bits += 50) {
        double value;
        Complex newton;
        value_at(p, x, value, newton);
        if (!(value > 0.0)) return;
        x -= WideComplex<L>(newton.re, newton.im);
    }
}

STEP double power_16(double x) {
    for (int k = 0; k < 4; ++k) x *= x;
    return x;
}
// All roots, with discs that hold them (Smith 1970, see root_discs).
template <int L> PART void roots_of(const HalfTangent<L>& p, WideRoot<L> (&root)[ROOTS]) {
    start_roots(p, root);
    separate_roots(p, root);
    improve_roots(p, root);
    int group[ROOTS];
    Complex at[ROOTS];
    for (int i = 0; i < ROOTS; ++i) {
        Complex newton;
        double value;
        value_at(p, root[i].x, value, newton);
        at[i] = leading(root[i].x);
        const double leading_size = abs(p.a[ROOTS].wide().leading()) - p.error;
        const double size = size_of(at[i]), longest = power_16(max(size, 1.0)) * SLACK_OF_SUMS;
        double apart = 1.0;
        for (int j = 0; j < ROOTS; ++j) {
            if (j != i) apart *= size_of(leading(root[i].x - root[j].x));
        }
        const double above = SLACK_OF_SUMS * ROOTS * (value * longest + p.error * power_16(1.0 + size));
        root[i].radius = leading_size > 0.0 && apart > 0.0 ? above / (leading_size * apart) : __builtin_inf();
        group[i] = i;
    }
    for (int i = 0; i < ROOTS; ++i) {
        for (int j = 0; j < i; ++j) {
            if (size_of(leading(root[i].x - root[j].x)) > SLACK_OF_SUMS * (root[i].radius + root[j].radius)) continue;
            const int from = group[i], to = group[j];
            for (int& each : group) each = each == from ? to : each;
        }
    }
    for (int i = 0; i < ROOTS; ++i) {
        root[i].together = 0;
        for (const int each : group) root[i].together += each == group[i];
        const bool wide = !(root[i].radius < 1.0);
        root[i].least = wide ? 0.0 : imaginary_part(at[i], max(abs(at[i].im) - root[i].radius, 0.0));
    }
}

// ---- the other joints ----------------------------------------------------------------------------------------------------

template <int L> STEP double square_of(const Wide<L>& a) {
    const double x = a.leading();
    return x * x;
}
template <int L> STEP double square_of(const WideComplex<L>& a) { return square_of(a.re) + square_of(a.im); }

template <int L> STEP bool is_zero(const Wide<L>& a) { return a.is_zero(); }
template <int L> STEP bool is_zero(const WideComplex<L>& a) { return a.re.is_zero() && a.im.is_zero(); }

// A null vector by elimination, with pivots from any column once the zeros are used up: the last pivot is what rounding leaves of
// zero.
inline constexpr int SPARSE = 6;
template <class V> PART bool null_vector(FixedOf<V> (&M)[UNKNOWNS][UNKNOWNS], V (&x)[UNKNOWNS]) {
    using F = FixedOf<V>;
    constexpr int N = UNKNOWNS;
    int column[N];
    double last = 0.0;
    V over[N];
    for (int j = 0; j < N; ++j) column[j] = j;
    for (int k = 0; k < N - 1; ++k) {
        int r = k, c = k;
        double most = -1.0;
        for (int i = k; i < N; ++i) {
            for (int j = k; j < (k < SPARSE ? k + 1 : N); ++j) {
                if (M[i][j].is_zero()) continue;
                const double size = square_of(M[i][j]);
                if (size > most) most = size, r = i, c = j;
            }
        }
        last = most;
        if (!(most > 0.0)) return false;
        if (r != k) {
            for (int j = k; j < N; ++j) exchange(M[k][j], M[r][j]);
        }
        if (c != k) {
            exchange(column[k], column[c]);
            for (int i = 0; i < N; ++i) exchange(M[i][k], M[i][c]);
        }
        over[k] = inverse(M[k][k].wide());
        for (int i = k + 1; i < N; ++i) {
            if (M[i][k].is_zero()) continue;
            const F f = {M[i][k].wide() * over[k], 0};
            for (int j = k + 1; j < N; ++j) {
                if (!M[k][j].is_zero()) M[i][j].subtract(f, M[k][j]);
            }
        }
    }
    // Squares: the null vector has ten digits at least.
    if (!(square_of(M[N - 1][N - 1]) < 1e-20 * last)) return false;
    x[column[N - 1]] = 1.0;
    for (int k = N - 2; k >= 0; --k) {
        V sum = 0.0;
        for (int j = k + 1; j < N; ++j) {
            if (!M[k][j].is_zero()) sum += M[k][j].wide() * x[column[j]];
        }
        x[column[k]] = (V(0.0) - sum) * over[k];
    }
    return true;
}

// e^(i angle), rounded.
template <int L> STEP Complex circle_of(const Turn<Wide<L>>& t) { return {t.c.leading(), t.s.leading()}; }
template <int L> STEP Complex circle_of(const Turn<WideComplex<L>>& t) {
    const Complex c = leading(t.c), s = leading(t.s);
    return {c.re - s.im, c.im + s.re};
}
template <class V, int L> STEP Vec<V> lifted(const Vec<Wide<L>>& a) { return {lifted<V>(a.x), lifted<V>(a.y), lifted<V>(a.z)}; }
template <int L> STEP Vec<double> rounded(const Vec<Wide<L>>& a) { return {a.x.leading(), a.y.leading(), a.z.leading()}; }

// The turns of joints a + 3, a + 4 and a + 5 at a root.
template <int L, class V> PART bool other_turns(const WideEquations<L>& of, const Turn<Wide<L>>& centre, const V& x,
                                                Turn<V> (&turn)[3]) {
    // (1, cos, sin) times 1 + x^2; far from real that is nearly zero, and far out large.
    const V square = x * x, c = V(1.0) - square, s = x + x, c0 = lifted<V>(centre.c), s0 = lifted<V>(centre.s);
    const V weight[3] = {V(1.0) + square, c * c0 - s * s0, s * c0 + c * s0};
    const int exponent = larger(larger(exponent_of(weight[0]), exponent_of(weight[1])), exponent_of(weight[2]));
    V v[UNKNOWNS];
    FixedOf<V> M[UNKNOWNS][UNKNOWNS];
    matrix_at(of, {FixedOf<V>(weight[0], exponent), {weight[1], exponent}, {weight[2], exponent}}, M);
    if (!null_vector(M, v)) return false;
    const V over = inverse(weight[0]);
    turn[2] = {weight[1] * over, weight[2] * over};
    // v is (1, cos, sin) of joint a + 3 times C^3, S^3, C^2 S and C S^2, with the cosine and sine of half the angle of joint a + 4.
    int i = 0;
    for (int k = 3; k < UNKNOWNS; k += 3) {
        if (square_of(v[k]) > square_of(v[i])) i = k;
    }
    const bool cosine = square_of(v[0]) > square_of(v[3]);
    const V one = inverse(v[i]), half_c = v[cosine ? 0 : 9] * one, half_s = v[cosine ? 6 : 3] * one;
    const V length = half_c * half_c + half_s * half_s;
    if (!(square_of(length) > 0.0)) return false;
    const V scale = inverse(length), c_too = (half_c * half_c - half_s * half_s) * scale, product = half_c * half_s;
    const V s_too = (product + product) * scale;
    using Real = RealOf<V>;
    const Real fifth = inverse(Real(5.0));
    const V c_from = lifted<V>(Real(TOO_COSINE) * fifth), s_from = lifted<V>(Real(TOO_SINE) * fifth);
    turn[0] = {v[i + 1] * one, v[i + 2] * one};
    turn[1] = {c_too * c_from - s_too * s_from, s_too * c_from + c_too * s_from};
    return true;
}

// The turns of joints a and a + 1: the line that the others give, by the products of both.
template <int L, class V> PART bool first_turns(const WideEquations<L>& of, const Turn<V> (&others)[3], Turn<V> (&turn)[2]) {
    const auto lifted_line = [](const WideLine<Wide<L>>& l) { return WideLine<V>{lifted<V>(l.p), lifted<V>(l.d)}; };
    const Rot<Wide<L>>& R = of.pose.G.R;
    const Frame<V> G = {{lifted<V>(R.x), lifted<V>(R.y), lifted<V>(R.z)}, lifted<V>(of.pose.G.p)};
    V w[NUMBERS], y[PRODUCTS], z[PRODUCTS];
    numbers_of(of.other_side(lifted_line(of.axis(2)), G,
                             [&](int k, const WideLine<V>& l) {
                                 return turned_about(l, lifted_line(of.axis(3 + k)), Turn<V>{others[k].c, V(0.0) - others[k].s});
                             }),
               w);
    for (int i = 0; i < PRODUCTS; ++i) {
        y[i] = w[of.row[i]];
        for (int j = 0; j < i; ++j) y[i] -= lifted<V>(of.factor[i][j]) * y[j];
    }
    for (int i = PRODUCTS - 1; i >= 0; --i) {
        V& sum = y[i];
        if (of.factor[i][i].is_zero()) return false;
        for (int j = i + 1; j < PRODUCTS; ++j) sum -= lifted<V>(of.factor[i][j]) * y[j];
        sum = sum * lifted<V>(inverse(RealOf<V>(of.factor[i][i])));
        z[of.column[i]] = sum;
    }
    if (!(square_of(z[0]) > 0.0)) return false;
    const V over = inverse(z[0]);
    turn[0] = {z[3] * over, z[6] * over}, turn[1] = {z[1] * over, z[2] * over};
    return true;
}

// All joints at a root, e^(i angle) in the loop's order from joint a on.
template <int L, class V> PART bool joints_from(const WideEquations<L>& of, const Turn<Wide<L>>& centre, const V& x,
                                                Complex (&z)[6]) {
    Turn<V> others[3], first[2];
    if (!other_turns(of, centre, x, others) || !first_turns(of, others, first)) return false;
    for (int k = 0; k < 3; ++k) z[3 + k] = circle_of(others[k]);
    for (int k = 0; k < 2; ++k) z[k] = circle_of(first[k]);
    // Joint a + 2 turns a vector across its axis to where the others do.
    const auto complex = [](const Vec<double>& a) { return Vec<Complex>{a.x, a.y, a.z}; };
    const Vec<double> h = rounded(of.axis(2).d);
    const Vec<double> side = abs(h.x) < 0.6 ? cross(h, Vec<double>{1.0, 0.0, 0.0}) : cross(h, Vec<double>{0.0, 1.0, 0.0});
    const Vec<Complex> axis = complex(h), across = complex(side);
    const Rot<Wide<L>>& R = of.pose.G.R;
    const Rot<Complex> G = {complex(rounded(R.x)), complex(rounded(R.y)), complex(rounded(R.z))};
    const auto undone = [&](const Vec<Complex>& v, int k) {
        const Turn<Complex> t = turn_of(z[k]);
        return turned_about(v, complex(rounded(of.axis(k).d)), Turn<Complex>{t.c, -t.s});
    };
    Vec<Complex> v = across;
    for (int k = 0; k < 4; ++k) {
        if (k + of.first == 3) v = G * v;
        if (k < 3) v = undone(v, 3 + k);
    }
    for (int k = 0; k < 2; ++k) v = undone(v, k);
    const Complex c = dot(across, v), s = dot(axis, cross(across, v));
    z[2] = {c.re - s.im, c.im + s.re};
    return true;
}
template <int L> PART bool joints_at(const WideEquations<L>& of, const Turn<Wide<L>>& centre, const WideComplex<L>& x,
                                     Complex (&z)[6]) {
    const WideComplex<JOINT_LIMBS> cut = {Wide<JOINT_LIMBS>(x.re), Wide<JOINT_LIMBS>(x.im)};
    return x.im.is_zero() ? joints_from(of, centre, cut.re, z) : joints_from(of, centre, cut, z);
}

}  // namespace urdf_ik::URDF_IK_LEVEL
