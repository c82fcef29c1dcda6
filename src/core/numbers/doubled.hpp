// Numbers of twice the digits of a double, or packs of them, as an unevaluated sum of two doubles (Dekker 1971): sums, products,
// quotients and roots are off by less than DOUBLED_UNIT of their size, those of complex numbers by 3 times that.
#pragma once

#include <cstdint>

#include "numbers/complex.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

inline constexpr double DOUBLED_UNIT = 1.9721522630525295e-31;  // 2^-102

template <class V> struct DoubledOf {
    V hi, lo;
    DoubledOf() = default;
    STEP DoubledOf(double x) : hi(x), lo(0.0) {}
    STEP DoubledOf(const V& x, const V& y) : hi(x), lo(y) {}
    // The same number in each lane.
    template <class S>
        requires(std::is_same_v<S, double> && !std::is_same_v<V, double>)
    STEP DoubledOf(const DoubledOf<S>& x) : hi(x.hi), lo(x.lo) {}

    // The exact sum of two doubles, and the same where |a| >= |b|.
    static STEP DoubledOf sum(const V& a, const V& b) {
        const V s = a + b, t = s - a;
        return {s, (a - (s - t)) + (b - t)};
    }
    static STEP DoubledOf quick_sum(const V& a, const V& b) {
        const V s = a + b;
        return {s, b - (s - a)};
    }

    // The exact product of two doubles.
    static STEP DoubledOf product(const V& a, const V& b) {
#if defined(URDF_IK_FUSES)
        // The sum with zero keeps the compiler from replacing the rounded product by the exact one in other sums.
        const V p = fused(a, b, V(0.0));
        return {p, fused(a, b, -p)};
#else
        // By halves of 26 and 27 binary digits, whose products are exact.
        const V p = a * b, x = upper_half(a), y = upper_half(b), u = a - x, v = b - y;
        return {p, u * v - (((p - x * y) - u * y) - x * v)};
#endif
    }

    friend PART DoubledOf operator+(const DoubledOf& a, const DoubledOf& b) {
        const DoubledOf s = sum(a.hi, b.hi), t = sum(a.lo, b.lo);
        const DoubledOf u = quick_sum(s.hi, s.lo + t.hi);
        return quick_sum(u.hi, u.lo + t.lo);
    }
    friend STEP DoubledOf operator-(const DoubledOf& a) { return {-a.hi, -a.lo}; }
    friend STEP DoubledOf operator-(const DoubledOf& a, const DoubledOf& b) { return a + -b; }
    friend PART DoubledOf operator*(const DoubledOf& a, const DoubledOf& b) {
        const DoubledOf p = product(a.hi, b.hi);
        return quick_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
    }
    friend PART DoubledOf operator/(const DoubledOf& a, const DoubledOf& b) {
        const DoubledOf first = {a.hi / b.hi, V(0.0)}, left = a - first * b, second = {left.hi / b.hi, V(0.0)};
        const DoubledOf rest = left - second * b;
        return first + second + DoubledOf(rest.hi / b.hi, V(0.0));
    }
    // In place, and off by less than DOUBLED_UNIT of the number before and of the product: where these cancel, of more than the
    // sum.
    STEP void add_product(const DoubledOf& a, const DoubledOf& b) {
        const DoubledOf p = product(a.hi, b.hi), s = sum(hi, p.hi);
        *this = quick_sum(s.hi, s.lo + (lo + (p.lo + (a.hi * b.lo + a.lo * b.hi))));
    }
    STEP DoubledOf& operator+=(const DoubledOf& b) { return *this = *this + b; }
    STEP DoubledOf& operator-=(const DoubledOf& b) { return *this = *this - b; }
};
using Doubled = DoubledOf<double>;
using DoubledBlock = DoubledOf<Block>;
STEP DoubledBlock load_doubled(const double* a, const double* rest) { return DoubledBlock::sum(load<Block>(a), load<Block>(rest)); }
STEP void store(const DoubledBlock& a, Doubled* to) {
    for (int l = 0; l < BLOCK; ++l) to[l] = {a.hi[l], a.lo[l]};
}
template <class V> inline constexpr bool IS_CALLED<DoubledOf<V>> = true;

// to + a b.
template <class V> STEP void add_product(V& to, const V& a, const V& b) { to += a * b; }
template <class V> STEP void add_product(DoubledOf<V>& to, const DoubledOf<V>& a, const DoubledOf<V>& b) { to.add_product(a, b); }

// A number to the digits of a double.
STEP double leading(double a) { return a; }
template <int L, int K> STEP Pack<L, K> leading(const Pack<L, K>& a) { return a; }
template <class V> STEP V leading(const DoubledOf<V>& a) { return a.hi; }

// a > 0 with the sign of b.
template <class V> STEP DoubledOf<V> copysign(const DoubledOf<V>& a, const DoubledOf<V>& b) {
    return {select(b.hi < V(0.0), -a.hi, a.hi), select(b.hi < V(0.0), -a.lo, a.lo)};
}
// As of complex numbers.
template <class V> STEP const DoubledOf<V>& conj(const DoubledOf<V>& a) { return a; }
template <class V> STEP DoubledOf<V> square(const DoubledOf<V>& a) { return a * a; }
template <class V> STEP DoubledOf<V> scaled(const DoubledOf<V>& f, const DoubledOf<V>& a) { return f * a; }

// The square root of a > 0: one step of Newton's method doubles the digits of the one in doubles.
template <class V> STEP DoubledOf<V> sqrt(const DoubledOf<V>& a) {
    const DoubledOf<V> s = {sqrt(a.hi), V(0.0)};
    return s + DoubledOf<V>((a - s * s).hi / (2.0 * s.hi), V(0.0));
}

}  // namespace urdf_ik::URDF_IK_LEVEL
