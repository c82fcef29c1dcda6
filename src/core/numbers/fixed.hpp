// Numbers of L 64-bit limbs with a fixed point, for eliminations, whose entries have one size: a product is taken away in a quarter
// of the time that numbers with exponents (wide.hpp) need. Integers only: the same bits everywhere.
#pragma once

#include "numbers/wide.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A number is below 2^15 in size. A product is off by less than two FIXED_UNIT<L>.
inline constexpr int WHOLE_BITS = 16;
template <int L> inline constexpr double FIXED_UNIT = WIDE_UNIT<L> * (1 << (WHOLE_BITS - 2));

// a - (b & mask).
template <int L> STEP void subtract_limbs(std::uint64_t* a, const std::uint64_t* b, std::uint64_t mask) {
    unsigned char borrow = 0;
#pragma GCC unroll 8
    for (int i = 0; i < L; ++i) a[i] = difference64(a[i], b[i] & mask, borrow);
}

// A number in two's complement, the lowest limb first.
template <int L> struct Fixed {
    using Real = Fixed;
    std::uint64_t m[L];

    Fixed() = default;
    // The first limbs of more.
    template <int M> explicit STEP Fixed(const Fixed<M>& a) { __builtin_memcpy(m, a.m + M - L, sizeof m); }
    // x 2^-exponent, cut off.
    PART Fixed(const Wide<L>& x, int exponent) : m{} {
        const int shift = WHOLE_BITS - x.exponent + exponent;
        if (x.is_zero() || shift >= 64 * L) return;
        shift_right(x.m, shift, 0, m);
        if (x.negative) *this = -*this;
    }
    PART Wide<L> wide() const {
        Wide<L> out;
        const Fixed above = sign() ? -*this : *this;
        __builtin_memcpy(out.m, above.m, sizeof m);
        out.exponent = WHOLE_BITS, out.negative = sign();
        return out.normalised();
    }
    STEP std::uint64_t sign() const { return 0 - (m[L - 1] >> 63); }
    // times 2^bits, cut off.
    STEP Fixed times_power(int bits) const {
        Fixed out;
        if (bits < 0) shift_right(m, -bits, sign(), out.m);
        else shift_left(m, bits, out.m);
        return out;
    }
    // The first digits, to three roundings of doubles.
    PART double leading() const {
        const Fixed above = sign() ? -*this : *this;
        int top = L - 1;
        while (top > 1 && !above.m[top]) --top;
        const double x = double(above.m[top]) + 0x1p-64 * double(above.m[top - 1]);
        return (sign() ? -x : x) * power_of_two(64 * (top + 1 - L) + WHOLE_BITS - 64);
    }
    // Whether |a| < |b|, or they are a unit apart.
    static STEP bool is_less(const Fixed& a, const Fixed& b) {
        for (int i = L; i-- > 0;) {
            const std::uint64_t x = a.m[i] ^ a.sign(), y = b.m[i] ^ b.sign();
            if (x != y) return x < y;
        }
        return false;
    }
    STEP bool is_zero() const {
        std::uint64_t any = 0;
        for (const std::uint64_t each : m) any |= each;
        return !any;
    }
    friend STEP Fixed operator-(const Fixed& a) {
        Fixed out = {};
        subtract_limbs<L>(out.m, a.m, ~std::uint64_t(0));
        return out;
    }
    STEP Fixed& operator-=(const Fixed& b) {
        subtract_limbs<L>(m, b.m, ~std::uint64_t(0));
        return *this;
    }
    friend PART Fixed operator*(const Fixed& a, const Fixed& b) { return product(a, b); }
    PART void subtract(const Fixed& a, const Fixed& b) { *this -= product(a, b); }
    static STEP Fixed product(const Fixed& a, const Fixed& b) {
        std::uint64_t p[2 * L];
        multiply_limbs(a.m, b.m, p);
        subtract_limbs<L>(p + L, b.m, a.sign()), subtract_limbs<L>(p + L, a.m, b.sign());
        Fixed out;
        for (int i = 0; i < L; ++i) out.m[i] = upper_of(p[L + i], p[L + i - 1], WHOLE_BITS);
        return out;
    }
    friend STEP Fixed operator-(Fixed a, const Fixed& b) { return a -= b; }
    STEP Fixed& operator+=(const Fixed& b) {
        unsigned char carry = 0;
#pragma GCC unroll 8
        for (int i = 0; i < L; ++i) m[i] = sum64(m[i], b.m[i], carry);
        return *this;
    }
    friend STEP Fixed operator+(Fixed a, const Fixed& b) { return a += b; }
};

// ---- quotients and roots: Newton's method doubles the digits of doubles ------------------------------------------------------

// 1 / n for n in [1/2, 1), each step in the limbs that it fills.
template <int L> PART Fixed<L> inverse(const Fixed<L>& n) {
    Fixed<L> x;
    if constexpr (L == 2) {
        x = {Wide<L>(1.0 / n.leading()), 0};
    } else {
        constexpr int K = L / 2 + 1;
        Fixed<K> first;
        __builtin_memcpy(first.m, n.m + L - K, sizeof first.m);
        first = inverse(first), x = {};
        __builtin_memcpy(x.m + L - K, first.m, sizeof first.m);
    }
    Fixed<L> left = {};
    left.m[L - 1] = std::uint64_t(1) << (64 - WHOLE_BITS), left -= Fixed<L>::product(n, x);
    return x + Fixed<L>::product(x, left);
}
template <int L> PART Wide<L> inverse(const Wide<L>& a) {
    Fixed<L + 1> n = {};
    for (int i = 0; i < L; ++i) n.m[i] |= a.m[i] << (64 - WHOLE_BITS), n.m[i + 1] = a.m[i] >> WHOLE_BITS;
    const Wide<L + 1> x = inverse(n).wide();
    Wide<L> out;
    for (int i = 0; i < L; ++i) out.m[i] = x.m[i + 1];
    out.exponent = x.exponent - a.exponent, out.negative = a.negative;
    return out;
}
template <int L> PART WideComplex<L> inverse(const WideComplex<L>& a) {
    const Wide<L> w = inverse(a.re * a.re + a.im * a.im);
    return {a.re * w, -(a.im * w)};
}
// One over the root of n > 0.
template <int L> PART Wide<L> inverse_root(const Wide<L>& n) {
    Wide<L> x = 1.0 / sqrt(n.leading()), one = 1.0;
    for (int bits = 50; bits < 64 * L; bits *= 2) x += half(x * (one - n * x * x));
    return x;
}

template <int L> STEP int exponent_of(const Fixed<L>& a) { return exponent_of(a.wide()); }
template <int L> STEP Fixed<L> half(const Fixed<L>& a) { return a.times_power(-1); }
template <int L> STEP double square_of(const Fixed<L>& a) {
    const double x = a.leading();
    return x * x;
}

template <int L> struct FixedComplex {
    using Real = Fixed<L>;
    Fixed<L> re, im;

    FixedComplex() = default;
    FixedComplex(const Fixed<L>& x, const Fixed<L>& y) : re(x), im(y) {}
    FixedComplex(const WideComplex<L>& x, int exponent) : re(x.re, exponent), im(x.im, exponent) {}
    STEP WideComplex<L> wide() const { return {re.wide(), im.wide()}; }
    STEP bool is_zero() const { return re.is_zero() && im.is_zero(); }
    STEP FixedComplex& operator-=(const FixedComplex& b) {
        re -= b.re, im -= b.im;
        return *this;
    }
    PART void subtract(const FixedComplex& a, const FixedComplex& b) {
        re.subtract(a.re, b.re), re += a.im * b.im;
        im.subtract(a.re, b.im), im.subtract(a.im, b.re);
    }
    friend PART FixedComplex operator*(const FixedComplex& a, const FixedComplex& b) {
        return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
    }
    friend PART FixedComplex operator*(const FixedComplex& a, const Fixed<L>& b) { return {a.re * b, a.im * b}; }
    friend STEP FixedComplex operator-(FixedComplex a, const FixedComplex& b) { return a -= b; }
    friend STEP FixedComplex operator+(const FixedComplex& a, const FixedComplex& b) { return {a.re + b.re, a.im + b.im}; }
};
template <int L> STEP double square_of(const FixedComplex<L>& a) { return square_of(a.re) + square_of(a.im); }

// The number with a fixed point that belongs to one with an exponent.
template <int L> Fixed<L> fixed_for(const Wide<L>&);
template <int L> FixedComplex<L> fixed_for(const WideComplex<L>&);
template <class V> using FixedOf = decltype(fixed_for(V()));

}  // namespace urdf_ik::URDF_IK_LEVEL
