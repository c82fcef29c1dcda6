// Numbers of L 64-bit limbs, where the digits of doubles, or twice as many, do not suffice. Integers only: the same bits
// everywhere.
//
// A number is zero, or +-0.m 2^exponent, with m in [1/2, 1) as limbs, the lowest first. Results are cut off: a product or quotient
// is off by less than WIDE_UNIT<L> of its size, a sum or difference by less than WIDE_UNIT<L> of its larger operand.
#pragma once

#include <cstdint>

#include "numbers/complex.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

struct Product64 {
    std::uint64_t low, high;
};
STEP Product64 product64(std::uint64_t a, std::uint64_t b) {
#if defined(__SIZEOF_INT128__)
    const auto p = static_cast<unsigned __int128>(a) * b;
    return {std::uint64_t(p), std::uint64_t(p >> 64)};
#else
    const std::uint64_t half = 0xffffffffu, al = a & half, ah = a >> 32, bl = b & half, bh = b >> 32;
    const std::uint64_t first = al * bl, middle = ah * bl + (first >> 32), other = al * bh + (middle & half);
    return {(other << 32) | (first & half), ah * bh + (middle >> 32) + (other >> 32)};
#endif
}

// a + b + carry and a - b - carry, and the next carry. Compilers do not find the instructions that x86-64 has for it.
#if defined(__x86_64__)
STEP std::uint64_t sum64(std::uint64_t a, std::uint64_t b, unsigned char& carry) {
    unsigned long long out;
    carry = _addcarry_u64(carry, a, b, &out);
    return out;
}
STEP std::uint64_t difference64(std::uint64_t a, std::uint64_t b, unsigned char& carry) {
    unsigned long long out;
    carry = _subborrow_u64(carry, a, b, &out);
    return out;
}
#else
STEP std::uint64_t sum64(std::uint64_t a, std::uint64_t b, unsigned char& carry) {
    const std::uint64_t x = a + b, out = x + carry;
    carry = (x < a) | (out < x);
    return out;
}
STEP std::uint64_t difference64(std::uint64_t a, std::uint64_t b, unsigned char& carry) {
    const std::uint64_t x = a - b, out = x - carry;
    carry = (a < b) | (x < out);
    return out;
}
#endif

// The upper limb of two that are shifted to the left by less than a limb. One limb after the other: vectors of limbs would have to
// wait until the limbs that they are made of have reached memory.
STEP std::uint64_t upper_of(std::uint64_t high, std::uint64_t low, int shift) {
#if defined(__SIZEOF_INT128__)
    return std::uint64_t(((static_cast<unsigned __int128>(high) << 64) | low) >> (64 - shift));
#else
    return high << shift | low >> 1 >> (63 - shift);
#endif
}

// The lower limb of two that are shifted to the right by less than a limb.
STEP std::uint64_t lower_of(std::uint64_t high, std::uint64_t low, int shift) {
#if defined(__SIZEOF_INT128__)
    return std::uint64_t(((static_cast<unsigned __int128>(high) << 64) | low) >> shift);
#else
    return low >> shift | high << 1 << (63 - shift);
#endif
}

// Limbs times 2^bits and 2^-bits; `above`: all limbs beyond the last one.
template <int L> STEP void shift_left(const std::uint64_t (&m)[L], int bits, std::uint64_t (&out)[L]) {
    const int words = bits / 64, rest = bits % 64;
    if (words == 0) {
#pragma GCC unroll 8
        for (int i = 0; i < L; ++i) out[i] = upper_of(m[i], i ? m[i - 1] : 0, rest);
        return;
    }
    for (int i = 0; i < L; ++i) out[i] = i < words ? 0 : upper_of(m[i - words], i > words ? m[i - words - 1] : 0, rest);
}
template <int L> STEP void shift_right(const std::uint64_t (&m)[L], int bits, std::uint64_t above, std::uint64_t (&out)[L]) {
    const int words = bits / 64, rest = bits % 64;
    if (words == 0) {
#pragma GCC unroll 8
        for (int i = 0; i < L; ++i) out[i] = lower_of(i + 1 < L ? m[i + 1] : above, m[i], rest);
        return;
    }
    for (int i = 0; i < L; ++i) {
        out[i] = i + words < L ? lower_of(i + words + 1 < L ? m[i + words + 1] : above, m[i + words], rest) : above;
    }
}

// p = a b from limb L - 2 on. Products of limbs that are less than a unit together are left out.
template <int L> STEP void multiply_limbs(const std::uint64_t (&a)[L], const std::uint64_t (&b)[L], std::uint64_t (&p)[2 * L]) {
    std::uint64_t low = 0, middle = 0, high = 0;
#pragma GCC unroll 16
    for (int k = L - 2; k < 2 * L - 1; ++k) {
#pragma GCC unroll 8
        for (int i = k < L ? 0 : k - L + 1; i <= k && i < L; ++i) {
            const Product64 each = product64(a[i], b[k - i]);
            unsigned char carry = 0;
            low = sum64(low, each.low, carry), middle = sum64(middle, each.high, carry), high = sum64(high, 0, carry);
        }
        p[k] = low, low = middle, middle = high, high = 0;
    }
    p[2 * L - 1] = low;
}

// 2^exponent, for results that doubles can hold; 0 below, infinity above.
STEP double power_of_two(int exponent) {
    if (exponent < -1022) return 0.0;
    if (exponent > 1023) return __builtin_inf();
    const std::uint64_t bits = std::uint64_t(exponent + 1023) << 52;
    double x;
    __builtin_memcpy(&x, &bits, sizeof x);
    return x;
}

constexpr double wide_unit(int limbs) {
    double unit = 4.0;
    for (int i = 0; i < limbs; ++i) unit /= 18446744073709551616.0;
    return unit;
}
template <int L> inline constexpr double WIDE_UNIT = wide_unit(L);

template <int L> struct Wide {
    std::uint64_t m[L];
    int exponent;
    bool negative;

    Wide() = default;
    PART Wide(double x) : m{}, exponent(0), negative(x < 0.0) {
        std::uint64_t bits;
        __builtin_memcpy(&bits, &x, sizeof x);
        const int e = int(bits >> 52 & 2047);
        if (!e) return;  // zero; smaller than any number that is used
        m[L - 1] = (bits << 11) | (std::uint64_t(1) << 63), exponent = e - 1022;
    }
    // The first limbs of more.
    template <int M> explicit STEP Wide(const Wide<M>& a) : exponent(a.exponent), negative(a.negative) {
        __builtin_memcpy(m, a.m + M - L, sizeof m);
    }

    STEP bool is_zero() const { return !m[L - 1]; }
    // The first 53 digits; numbers beyond the range of doubles become zero.
    PART double leading() const {
        if (is_zero()) return 0.0;
        const double x = double(m[L - 1] >> 11) * power_of_two(exponent - 53);
        return negative ? -x : x;
    }
    STEP Wide times_power(int k) const {
        Wide out = *this;
        out.exponent += k;
        return out;
    }

    friend PART Wide operator-(const Wide& a) {
        Wide out = a;
        out.negative = !a.negative;
        return out;
    }
    friend PART Wide operator*(const Wide& a, const Wide& b) {
        if (a.is_zero() || b.is_zero()) return Wide(0.0);
        std::uint64_t p[2 * L];
        multiply_limbs(a.m, b.m, p);
        Wide out;
        const bool top = p[2 * L - 1] >> 63;
        for (int i = 0; i < L; ++i) out.m[i] = upper_of(p[L + i], p[L + i - 1], !top);
        out.exponent = a.exponent + b.exponent - !top, out.negative = a.negative != b.negative;
        return out;
    }
    friend STEP Wide operator+(const Wide& a, const Wide& b) { return sum(a, b, b.negative); }
    friend STEP Wide operator-(const Wide& a, const Wide& b) { return sum(a, b, !b.negative); }
    STEP Wide& operator+=(const Wide& b) { return *this = *this + b; }
    STEP Wide& operator-=(const Wide& b) { return *this = *this - b; }

    // Whether |a| < |b|.
    static STEP bool is_less(const Wide& a, const Wide& b) {
        if (a.is_zero() || b.is_zero()) return a.is_zero() && !b.is_zero();
        if (a.exponent != b.exponent) return a.exponent < b.exponent;
        for (int i = L; i-- > 0;) {
            if (a.m[i] != b.m[i]) return a.m[i] < b.m[i];
        }
        return false;
    }

    // a, and b with this sign.
    static PART Wide sum(const Wide& a, const Wide& b, bool sign) {
        if (b.is_zero()) return a;
        const bool swapped = is_less(a, b);
        const Wide &big = swapped ? b : a, &small = swapped ? a : b;
        const int shift = big.exponent - small.exponent;
        Wide out = big;
        out.negative = swapped ? sign : a.negative;
        if (small.is_zero() || shift >= 64 * L) return out;
        // The smaller one is added, or its complement.
        const bool differ = a.negative != sign;
        const std::uint64_t mask = 0 - std::uint64_t(differ);
        std::uint64_t t[L];
        unsigned char carry = differ;
        shift_right(small.m, shift, 0, t);
#pragma GCC unroll 8
        for (int i = 0; i < L; ++i) out.m[i] = sum64(out.m[i], t[i] ^ mask, carry);
        if (differ) return out.m[L - 1] >> 63 ? out : out.normalised();
        for (int i = 0; i < L; ++i) {
            const std::uint64_t next = i + 1 < L ? out.m[i + 1] : carry;
            out.m[i] = lower_of(next, out.m[i], int(carry));
        }
        out.exponent += int(carry);
        return out;
    }
    STEP Wide normalised() const {
        int top = L - 1;
        while (top >= 0 && !m[top]) --top;
        if (top < 0) return Wide(0.0);
        const int zeros = 64 * (L - 1 - top) + __builtin_clzll(m[top]);
        Wide out = *this;
        shift_left(m, zeros, out.m);
        out.exponent -= zeros;
        return out;
    }
};

template <int L> STEP double leading(const Wide<L>& a) { return a.leading(); }
STEP int larger(int a, int b) { return a > b ? a : b; }
template <int L> STEP int exponent_of(const Wide<L>& a) { return a.is_zero() ? -1000 : a.exponent; }
template <int L> STEP Wide<L> half(const Wide<L>& a) { return a.is_zero() ? a : a.times_power(-1); }

template <int L> inline constexpr bool IS_CALLED<Wide<L>> = true;
template <int L> using WideComplex = Complexes<Wide<L>>;
template <int L> PART WideComplex<L> operator*(const Wide<L>& f, const WideComplex<L>& a) { return {f * a.re, f * a.im}; }
template <int L> Wide<L> real_part(const Wide<L>&);
template <int L> Wide<L> real_part(const WideComplex<L>&);
template <class V> using RealOf = decltype(real_part(V()));
// A number as one of as many limbs or fewer, a complex one where V is complex.
template <class V, int L> STEP V lifted(const Wide<L>& a) {
    if constexpr (std::is_same_v<V, RealOf<V>>) return V(a);
    else return {RealOf<V>(a), 0.0};
}
template <int L> STEP WideComplex<L> half(const WideComplex<L>& a) { return {half(a.re), half(a.im)}; }
template <int L> STEP int exponent_of(const WideComplex<L>& a) { return larger(exponent_of(a.re), exponent_of(a.im)); }

}  // namespace urdf_ik::URDF_IK_LEVEL
