// Numbers of twice the digits of a double, as an unevaluated sum of two doubles (Dekker 1971): sums, products and quotients are off
// by less than DOUBLED_UNIT of their size, those of complex numbers by 3 times that.
#pragma once

#include <cstdint>

#include "arithmetic/vectors.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

inline constexpr double DOUBLED_UNIT = 1.9721522630525295e-31;  // 2^-102

struct Doubled {
    double hi, lo;
    Doubled() = default;
    STEP Doubled(double x) : hi(x), lo(0.0) {}
    STEP Doubled(double x, double y) : hi(x), lo(y) {}

    // The exact sum of two doubles, and the same where |a| >= |b|.
    static STEP Doubled sum(double a, double b) {
        const double s = a + b, t = s - a;
        return {s, (a - (s - t)) + (b - t)};
    }
    static STEP Doubled quick_sum(double a, double b) {
        const double s = a + b;
        return {s, b - (s - a)};
    }

    // The exact product of two doubles.
    static STEP Doubled product(double a, double b) {
#if defined(__FMA__) || defined(__ARM_FEATURE_FMA)
        // The sum with zero keeps the compiler from replacing the rounded product by the exact one in other sums.
        const double p = __builtin_fma(a, b, 0.0);
        return {p, __builtin_fma(a, b, -p)};
#else
        // By halves of 26 and 27 binary digits, whose products are exact.
        const double p = a * b, x = half(a), y = half(b), u = a - x, v = b - y;
        return {p, u * v - (((p - x * y) - u * y) - x * v)};
#endif
    }
    static STEP double half(double a) {
        return __builtin_bit_cast(double, __builtin_bit_cast(std::uint64_t, a) & ~((std::uint64_t(1) << 27) - 1));
    }

    friend STEP Doubled operator+(const Doubled& a, const Doubled& b) {
        const Doubled s = sum(a.hi, b.hi), t = sum(a.lo, b.lo);
        const Doubled u = quick_sum(s.hi, s.lo + t.hi);
        return quick_sum(u.hi, u.lo + t.lo);
    }
    friend STEP Doubled operator-(const Doubled& a) { return {-a.hi, -a.lo}; }
    friend STEP Doubled operator-(const Doubled& a, const Doubled& b) { return a + -b; }
    friend STEP Doubled operator*(const Doubled& a, const Doubled& b) {
        const Doubled p = product(a.hi, b.hi);
        return quick_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
    }
    friend STEP Doubled operator/(const Doubled& a, const Doubled& b) {
        const Doubled first = a.hi / b.hi, left = a - first * b, second = left.hi / b.hi, rest = left - second * b;
        return first + second + rest.hi / b.hi;
    }
    STEP Doubled& operator+=(const Doubled& b) { return *this = *this + b; }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
