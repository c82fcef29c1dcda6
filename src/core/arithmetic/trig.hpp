// Trigonometric functions without branching, for a number or a pack.
#pragma once

#include "arithmetic/simd.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

inline constexpr double PI = 3.141592653589793, TINY = 1e-300;

// An angle as its cosine and sine.
template <class V> struct Turn {
    V c, s;
};

// Angle of (x, y) in [-pi, pi]; 0 for (0, 0). Error below 2 units in the last place.
// The octant is folded to |t| <= tan(pi / 8), where (atan(t) / t - 1) / t^2 is its Chebyshev expansion in t^2, truncated
// after 11 terms: error 5e-18.
template <class V> STEP V atan2(V y, V x) {
    const V ax = abs(x), ay = abs(y), low = min(ax, ay), high = max(ax, ay);
    const auto folded = low > 0.41421356237309503 * high;
    const V t = quotient(select(folded, low - high, low), select(folded, low + high, high) + TINY);
    const V z = t * t;
    V p = -0.01917688711906226;
    p = p * z + 0.03923165829558719;
    p = p * z - 0.0508544973794026;
    p = p * z + 0.0585814891280221;
    p = p * z - 0.06664511447381948;
    p = p * z + 0.07692183190826087;
    p = p * z - 0.09090904578123903;
    p = p * z + 0.11111111015256361;
    p = p * z - 0.14285714284666542;
    p = p * z + 0.1999999999999552;
    p = p * z - 0.3333333333333333;
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

// The angle a in (-pi, pi], for any a. An angle inside is unchanged.
STEP double on_circle(double a) {
    if (abs(a) < PI) return a;
    const double rest = __builtin_remainder(a, 6.283185307179586);
    return rest <= -PI ? PI : min(rest, PI);
}

// The angle half a turn away; both are in (-pi, pi].
template <class V> STEP V half_turn_from(const V& a) {
    const V b = select(a > V(0.0), a - PI, a + PI);
    return select(b <= V(-PI), V(PI), b);  // a just above zero
}

inline constexpr double ROUNDS = 6755399441055744.0;  // adding and then subtracting it rounds to a whole number

// Cosine and sine of r + quarter * pi / 2: |r| at most a little over pi / 4, quarter a whole number from -2 to 2.
// The Chebyshev expansions of (sin x / x - 1) / x^2 and (cos x - 1 + x^2 / 2) / x^4 in x^2, truncated after six terms:
// error below 3e-17.
template <class V> STEP Turn<V> turn_by(V r, V quarter) {
    const V z = r * r;
    V p = 1.5916732964827756e-10;
    p = p * z - 2.5051112378038593e-08;
    p = p * z + 2.755731600874652e-06;
    p = p * z - 0.0001984126983657699;
    p = p * z + 0.008333333333330828;
    p = p * z - 0.16666666666666666;
    V s = r + r * (z * p);
    p = -1.1381758418038708e-11;
    p = p * z + 2.087613408272447e-09;
    p = p * z - 2.755731721300625e-07;
    p = p * z + 2.4801587298652004e-05;
    p = p * z - 0.0013888888888887322;
    p = p * z + 0.041666666666666664;
    V c = 1.0 - (0.5 * z - z * z * p);
    const auto opposite = abs(quarter) > V(1.5);
    const auto odd = (abs(quarter) > V(0.5)) & !opposite;
    c = select(opposite, -c, c), s = select(opposite, -s, s);
    return {select(odd, -(quarter * s), c), select(odd, quarter * c, s)};
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

// The same by the C library, for any angle.
STEP Turn<double> exact_turn(double angle) { return {__builtin_cos(angle), __builtin_sin(angle)}; }

// (c, s) scaled to length 1.
template <class V> STEP Turn<V> unit(V c, V s) {
    const V w = inverse_sqrt(c * c + s * s + TINY);
    return {c * w, s * w};
}

}  // namespace urdf_ik::URDF_IK_LEVEL
