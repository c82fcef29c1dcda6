// Trigonometric functions, for a number or a pack, and the exponential function and the logarithm, for a number. The C library's
// are used beyond FAR only: their last bits differ between systems.
#pragma once

#include <cstdint>

#include "numbers/angles.hpp"
#include "numbers/simd.hpp"
#include "numbers/thresholds.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

inline constexpr double TINY = 1e-300;

// An angle as its cosine and sine.
template <class V> struct Turn {
    V c, s;
};

// The polynomial with these coefficients, that of the highest power first.
template <class V, class... Rest> STEP V polynomial(const V& x, double highest, Rest... rest) {
    V p = highest;
    ((p = p * x + rest), ...);
    return p;
}

// Angle of (x, y) in [-pi, pi]; 0 for (0, 0). Error below 2.5 units in the last place.
// The octant is folded to |t| <= tan(pi / 8), where (atan(t) / t - 1) / t^2 is its Chebyshev expansion in t^2, truncated
// after 11 terms: error 5e-18.
template <class V> STEP V atan2(V y, V x) {
    const V ax = abs(x), ay = abs(y), low = min(ax, ay), high = max(ax, ay);
    const auto folded = low > 0.41421356237309503 * high;
    const V t = quotient(select(folded, low - high, low), select(folded, low + high, high) + TINY);
    const V z = t * t;
    const V p = polynomial(z, -0.01917688711906226, 0.03923165829558719, -0.0508544973794026, 0.0585814891280221,
                           -0.06664511447381948, 0.07692183190826087, -0.09090904578123903, 0.11111111015256361,
                           -0.14285714284666542, 0.1999999999999552, -0.3333333333333333);
    V a = t + t * (z * p);
    a = a + select(folded, V(0.7853981633974483), 0.0);
    a = select(ay > ax, 1.5707963267948966 - a, a);
    a = select(x < V(0.0), PI - a, a);
    return copysign(a, y);
}
template <class V> STEP V angle(const Turn<V>& t) { return atan2(t.s, t.c); }

// The angle a in (-pi, pi], for an a that is at most one turn outside.
template <class V> STEP V wrap(V a) {
    a = select(a > V(PI), a - 6.283185307179586, a);
    return select(a <= V(-PI), a + 6.283185307179586, a);
}

// The angle half a turn away; both are in (-pi, pi].
template <class V> STEP V half_turn_from(const V& a) {
    const V b = select(a > V(0.0), a - PI, a + PI);
    return select(b <= V(-PI), V(PI), b);  // a just above zero
}

inline constexpr double ROUNDS = 6755399441055744.0;  // adding and then subtracting it rounds to a whole number

// (sin x / x - 1) / x^2 and (cos x - 1 + x^2 / 2) / x^4 at z = x^2, |x| at most a little over pi / 4: their Chebyshev
// expansions in z, truncated after six terms. The error of sin x / x is below 3e-17, that of cos x below 1e-18.
template <class V> STEP V sine_rest(const V& z) {
    return polynomial(z, 1.5916732964827756e-10, -2.5051112378038593e-08, 2.755731600874652e-06, -0.0001984126983657699,
                      0.008333333333330828, -0.16666666666666666);
}
template <class V> STEP V cosine_rest(const V& z) {
    return polynomial(z, -1.1381758418038708e-11, 2.087613408272447e-09, -2.755731721300625e-07, 2.4801587298652004e-05,
                      -0.0013888888888887322, 0.041666666666666664);
}

// Cosine and sine of an angle that is quarter * pi / 2 more than the one given: quarter is a whole number from -2 to 2.
template <class V> STEP Turn<V> turned_by_quarters(V c, V s, const V& quarter) {
    const auto opposite = abs(quarter) > V(1.5);
    const auto odd = (abs(quarter) > V(0.5)) & !opposite;
    c = select(opposite, -c, c), s = select(opposite, -s, s);
    return {select(odd, -(quarter * s), c), select(odd, quarter * c, s)};
}

// Cosine and sine of r + quarter * pi / 2: |r| at most a little over pi / 4.
template <class V> STEP Turn<V> turn_by(V r, V quarter) {
    const V z = r * r, s = r + r * (z * sine_rest(z)), c = 1.0 - (0.5 * z - z * z * cosine_rest(z));
    return turned_by_quarters(c, s, quarter);
}

// Cosine and sine of an angle in [-1.1 pi, 1.1 pi], error below one unit in the last place of 1. The nearest multiple of pi / 2 is
// subtracted in two parts.
template <class V> STEP Turn<V> cos_sin(V a) {
    const V k = (a * 0.6366197723675814 + ROUNDS) - ROUNDS;
    return turn_by((a - k * 1.5707963267948966) - k * 6.123233995736766e-17, k);
}

// Beyond this angle [rad], k below has more than 20 bits, and the C library computes the functions.
inline constexpr double FAR = 1.6e6;

// The same for an angle of any size. pi / 2 is subtracted in three parts. The first two have 33 bits each, so their
// products with k are exact (Cody and Waite, Software Manual for the Elementary Functions, 1980).
template <class V> STEP Turn<V> cos_sin_of_any(V a) {
    const V k = (a * 0.6366197723675814 + ROUNDS) - ROUNDS;
    const V r = ((a - k * 1.5707963267341256) - k * 6.077100506303966e-11) - k * 2.0222662487959506e-21;
    Turn<V> t = turn_by(r, k - 4.0 * ((k * 0.25 + ROUNDS) - ROUNDS));
    if (any(abs(a) > V(FAR))) [[unlikely]] {
        for (int i = 0; i < lanes_of<V>; ++i) {
            const double x = lane(a, i);
            if (abs(x) > FAR) set_lane(t.c, i, __builtin_cos(x)), set_lane(t.s, i, __builtin_sin(x));
        }
    }
    return t;
}

// The same for a number, with an error below 0.9 units in the last place: what the angle lacks beside r is kept, and enters
// to first order. The rounding of 1 - z / 2 is added again, which is exact.
STEP Turn<double> exact_turn(double angle) {
    if (!(abs(angle) <= FAR)) return {__builtin_cos(angle), __builtin_sin(angle)};
    const double k = (angle * 0.6366197723675814 + ROUNDS) - ROUNDS, quarter = k - 4.0 * ((k * 0.25 + ROUNDS) - ROUNDS);
    const double first = angle - k * 1.5707963267341256, part = k * 6.077100506303966e-11, second = first - part;
    const double lacks = ((first - second) - part) - k * 2.0222662487959506e-21, r = second + lacks, rest = (second - r) + lacks;
    const double z = r * r, half = 0.5 * z, w = 1.0 - half;
    const double s = r + (r * (z * sine_rest(z)) + rest * w);
    const double c = w + (((1.0 - w) - half) + (z * z * cosine_rest(z) - r * rest));
    return turned_by_quarters(c, s, quarter);
}

// The angle in [0, pi] with a cosine in [-1, 1], error below 3.1 units in the last place.
STEP double acos(double cosine) { return atan2(sqrt((1.0 - cosine) * (1.0 + cosine)), cosine); }

// ---- for a number ------------------------------------------------------------------------------------------------------

// e^x, with an error below 0.6 units in the last place; infinity above 700, 0 below -700. A multiple k of log 2 is
// subtracted in two parts, the first of 31 bits. (e^r - 1 - r) / r^2 is its Chebyshev expansion for |r| <= log 2 / 2, truncated
// after eleven terms: error 4e-19.
STEP double exponential(double x) {
    if (!(abs(x) <= 700.0)) return x > 0.0 ? __builtin_inf() : x < 0.0 ? 0.0 : x;
    const double k = (x * 1.4426950408889634 + ROUNDS) - ROUNDS, high = x - k * 0.6931471801362932, low = k * 4.236521365809284e-10;
    const double r = high - low, rest = (high - r) - low;
    const double p = polynomial(r, 2.091813816945801e-09, 2.5105217695684516e-08, 2.7557263277791584e-07, 2.755725539833871e-06,
                                2.4801587336443602e-05, 0.00019841269874822307, 0.0013888888888879073, 0.008333333333326134,
                                0.04166666666666668, 0.1666666666666667, 0.5);
    const std::uint64_t bits = std::uint64_t(std::int64_t(k) + 1023) << 52;
    double power;
    __builtin_memcpy(&power, &bits, 8);
    const double sum = 1.0 + r;  // what it lacks is (1 - sum) + r
    return (sum + (((1.0 - sum) + r) + (r * r * p + rest))) * power;
}

// The natural logarithm, with an error below 0.9 units in the last place; minus infinity below 1e-300, NaN for NaN. x is
// (1 + f) 2^k with 1 + f between sqrt(1/2) and sqrt(2), s = f / (2 + f), and (atanh(s) / s - 1) / s^2 is its Chebyshev
// expansion in s^2, truncated after eight terms: error 6e-19. Then log(1 + f) = f - (f^2 / 2 - s (f^2 / 2 + 2 s^2 p)).
STEP double logarithm(double x) {
    if (!(x >= TINY)) return x < TINY ? -__builtin_inf() : x;
    if (!(x < __builtin_inf())) return x;
    std::int64_t bits;
    __builtin_memcpy(&bits, &x, 8);
    const std::int64_t k = (bits - 0x3fe6a09e667f3bcdLL) >> 52;
    bits -= k * (std::int64_t(1) << 52);
    double m;
    __builtin_memcpy(&m, &bits, 8);
    const double f = m - 1.0, s = f / (2.0 + f), z = s * s, half = 0.5 * f * f;
    const double p = polynomial(z, 0.06543749512170148, 0.06634342654043388, 0.07693121586270234, 0.09090897786105524,
                                0.11111111196197966, 0.14285714285400178, 0.20000000000000442, 0.3333333333333333);
    const double rest = s * (half + 2.0 * (z * p));
    return double(k) * 0.6931471801362932 + (f - (half - (rest + double(k) * 4.236521365809284e-10)));
}

// (c, s) scaled to length 1.
template <class V> STEP Turn<V> unit(V c, V s) {
    const V w = inverse_sqrt(c * c + s * s + TINY);
    return {c * w, s * w};
}

}  // namespace urdf_ik::URDF_IK_LEVEL
