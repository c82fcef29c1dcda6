// Pack<L, K>: K registers of L doubles each. The steps of the solvers are templates over a number type V. V is a Pack, with one
// pose or one candidate per lane, or a plain double.
#pragma once

#include <cstdint>
#include <type_traits>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "numbers/level.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Calls f with the constants FROM to TO - 1. GCC keeps arrays in registers only if their indices are constants before it unrolls
// loops; where arrays fill the processor's registers, this takes two thirds of a loop's time.
template <int FROM, int TO, class F> STEP void in_turn(const F& f) {
    if constexpr (FROM < TO) f(std::integral_constant<int, FROM>()), in_turn<FROM + 1, TO>(f);
}

template <class T> STEP void exchange(T& a, T& b) {
    const T c = a;
    a = b, b = c;
}

template <int L> struct Register {
    typedef double type __attribute__((vector_size(8 * L)));
    typedef double unaligned __attribute__((vector_size(8 * L), aligned(8), may_alias));
    typedef long long bits __attribute__((vector_size(8 * L)));
};

// ---- masks: the lanes in which a comparison holds ----------------------------------------------------------------

template <int L, int K> struct Mask {
#if defined(__AVX512F__)
    std::uint8_t m[K];  // GCC would keep the result of a vector comparison in a vector register
    static constexpr std::uint8_t all_lanes = (1u << L) - 1;
#else
    typename Register<L>::bits m[K];
#endif
    friend STEP Mask operator&(Mask a, const Mask& b) {
        for (int k = 0; k < K; ++k) a.m[k] &= b.m[k];
        return a;
    }
    friend STEP Mask operator|(Mask a, const Mask& b) {
        for (int k = 0; k < K; ++k) a.m[k] |= b.m[k];
        return a;
    }
    friend STEP Mask operator!(Mask a) {
#if defined(__AVX512F__)
        for (int k = 0; k < K; ++k) a.m[k] = ~a.m[k] & all_lanes;
#else
        for (int k = 0; k < K; ++k) a.m[k] = ~a.m[k];
#endif
        return a;
    }
};

// One bit per lane.
template <int L, int K> STEP unsigned bits(const Mask<L, K>& a) {
    unsigned r = 0;
    for (int k = 0; k < K; ++k) {
#if defined(__AVX512F__)
        r |= unsigned(a.m[k]) << (L * k);
#elif defined(__SSE2__)
#if defined(__AVX__)
        if constexpr (L == 4) r |= unsigned(_mm256_movemask_pd((__m256d)a.m[k])) << (L * k);
#endif
        if constexpr (L == 2) r |= unsigned(_mm_movemask_pd((__m128d)a.m[k])) << (L * k);
#else
        for (int l = 0; l < L; ++l) r |= unsigned(a.m[k][l] & 1) << (L * k + l);
#endif
    }
    return r;
}
STEP unsigned bits(bool a) { return a; }
template <class M> STEP bool any(const M& a) { return bits(a) != 0; }

// ---- packs -------------------------------------------------------------------------------------------------------

template <int L> STEP typename Register<L>::type filled(double x) { return x - typename Register<L>::type{}; }

template <int L, int K> struct Pack {
    static constexpr int lanes = L * K;
    typename Register<L>::type r[K];

    Pack() = default;
    STEP Pack(double x) {
        for (int k = 0; k < K; ++k) r[k] = filled<L>(x);
    }
    STEP double operator[](int lane) const { return r[lane / L][lane % L]; }
    STEP void set(int lane, double x) { r[lane / L][lane % L] = x; }

#define URDF_IK_ARITHMETIC(op)                                                     \
    friend STEP Pack operator op(Pack a, const Pack& b) {                          \
        for (int k = 0; k < K; ++k) a.r[k] = a.r[k] op b.r[k];                     \
        return a;                                                                  \
    }                                                                              \
    friend STEP Pack operator op(double a, const Pack& b) { return Pack(a) op b; } \
    friend STEP Pack operator op(const Pack& a, double b) { return a op Pack(b); } \
    STEP Pack& operator op## = (const Pack& b) { return *this = *this op b; }
    URDF_IK_ARITHMETIC(+)
    URDF_IK_ARITHMETIC(-)
    URDF_IK_ARITHMETIC(*)
    URDF_IK_ARITHMETIC(/)
#undef URDF_IK_ARITHMETIC
    friend STEP Pack operator-(Pack a) {
        for (int k = 0; k < K; ++k) a.r[k] = -a.r[k];
        return a;
    }

#if defined(__AVX512F__)
#define URDF_IK_COMPARISON(op, code)                                                                        \
    friend STEP Mask<L, K> operator op(const Pack& a, const Pack& b) {                                      \
        Mask<L, K> c;                                                                                       \
        for (int k = 0; k < K; ++k) {                                                                       \
            if constexpr (L == 8) c.m[k] = _mm512_cmp_pd_mask((__m512d)a.r[k], (__m512d)b.r[k], code);      \
            else if constexpr (L == 4) c.m[k] = _mm256_cmp_pd_mask((__m256d)a.r[k], (__m256d)b.r[k], code); \
            else c.m[k] = _mm_cmp_pd_mask((__m128d)a.r[k], (__m128d)b.r[k], code);                          \
        }                                                                                                   \
        return c;                                                                                           \
    }
#else
#define URDF_IK_COMPARISON(op, code)                                   \
    friend STEP Mask<L, K> operator op(const Pack& a, const Pack& b) { \
        Mask<L, K> c;                                                  \
        for (int k = 0; k < K; ++k) c.m[k] = a.r[k] op b.r[k];         \
        return c;                                                      \
    }
#endif
    URDF_IK_COMPARISON(<, _CMP_LT_OQ)
    URDF_IK_COMPARISON(<=, _CMP_LE_OQ)
    URDF_IK_COMPARISON(>, _CMP_GT_OQ)
    URDF_IK_COMPARISON(>=, _CMP_GE_OQ)
#undef URDF_IK_COMPARISON
};

// The type of a comparison of two V; the number of doubles in a V.
template <class V> using MaskOf = decltype(V() < V());
template <class V> inline constexpr int lanes_of = 1;
template <int L, int K> inline constexpr int lanes_of<Pack<L, K>> = L * K;

// One lane of a number or a pack.
STEP double lane(double a, int) { return a; }
template <int L, int K> STEP double lane(const Pack<L, K>& a, int i) { return a[i]; }
STEP void set_lane(double& a, int, double x) { a = x; }
template <int L, int K> STEP void set_lane(Pack<L, K>& a, int i, double x) { a.set(i, x); }

// a where the mask holds, else b.
template <int L, int K> STEP Pack<L, K> select(const Mask<L, K>& m, Pack<L, K> a, const Pack<L, K>& b) {
    for (int k = 0; k < K; ++k) {
#if defined(__AVX512F__)
        using R = typename Register<L>::type;
        if constexpr (L == 8) a.r[k] = (R)_mm512_mask_blend_pd(m.m[k], (__m512d)b.r[k], (__m512d)a.r[k]);
        else if constexpr (L == 4) a.r[k] = (R)_mm256_mask_blend_pd(m.m[k], (__m256d)b.r[k], (__m256d)a.r[k]);
        else a.r[k] = (R)_mm_mask_blend_pd(m.m[k], (__m128d)b.r[k], (__m128d)a.r[k]);
#else
        a.r[k] = m.m[k] ? a.r[k] : b.r[k];
#endif
    }
    return a;
}
template <int L, int K> STEP Pack<L, K> select(const Mask<L, K>& m, const Pack<L, K>& a, double b) {
    return select(m, a, Pack<L, K>(b));
}
template <int L, int K> STEP Pack<L, K> select(const Mask<L, K>& m, double a, const Pack<L, K>& b) {
    return select(m, Pack<L, K>(a), b);
}

#if defined(__FMA__) || defined(__ARM_FEATURE_FMA)
#define URDF_IK_FUSES
// a b + c, rounded once.
STEP double fused(double a, double b, double c) { return __builtin_fma(a, b, c); }
template <int L, int K> STEP Pack<L, K> fused(Pack<L, K> a, const Pack<L, K>& b, const Pack<L, K>& c) {
    for (int k = 0; k < K; ++k) {
        for (int l = 0; l < L; ++l) a.r[k][l] = __builtin_fma(a.r[k][l], b.r[k][l], c.r[k][l]);
    }
    return a;
}
#endif

// The smaller and the greater of two numbers; the second one if either is NaN. GCC would make two instructions of a comparison.
// With AVX-512, it warns about the unmasked intrinsics, and compiles the masked ones, with all lanes set, to the same instructions.
#if defined(__AVX512F__)
STEP __m512d lesser(__m512d a, __m512d b) { return _mm512_maskz_min_pd(0xff, a, b); }
STEP __m512d greater(__m512d a, __m512d b) { return _mm512_maskz_max_pd(0xff, a, b); }
#endif
#if defined(__AVX__)
STEP __m256d lesser(__m256d a, __m256d b) { return _mm256_min_pd(a, b); }
STEP __m256d greater(__m256d a, __m256d b) { return _mm256_max_pd(a, b); }
#endif
#if defined(__SSE2__)
STEP __m128d lesser(__m128d a, __m128d b) { return _mm_min_pd(a, b); }
STEP __m128d greater(__m128d a, __m128d b) { return _mm_max_pd(a, b); }
#else
template <class R> STEP R lesser(R a, R b) { return a < b ? a : b; }
template <class R> STEP R greater(R a, R b) { return a > b ? a : b; }
#endif
template <int L, int K> STEP Pack<L, K> min(Pack<L, K> a, const Pack<L, K>& b) {
    for (int k = 0; k < K; ++k) a.r[k] = lesser(a.r[k], b.r[k]);
    return a;
}
template <int L, int K> STEP Pack<L, K> max(Pack<L, K> a, const Pack<L, K>& b) {
    for (int k = 0; k < K; ++k) a.r[k] = greater(a.r[k], b.r[k]);
    return a;
}
template <int L, int K> STEP Pack<L, K> min(const Pack<L, K>& a, double b) { return min(a, Pack<L, K>(b)); }
template <int L, int K> STEP Pack<L, K> max(const Pack<L, K>& a, double b) { return max(a, Pack<L, K>(b)); }

template <int L, int K> STEP Pack<L, K> sqrt(Pack<L, K> a) {
    for (int k = 0; k < K; ++k) {
        for (int l = 0; l < L; ++l) a.r[k][l] = __builtin_sqrt(a.r[k][l]);
    }
    return a;
}

// Roughly one over a: to four digits if the processor has an instruction for it.
template <int L, int K> STEP Pack<L, K> rough_inverse(Pack<L, K> a) {
    for (int k = 0; k < K; ++k) {
#if defined(__AVX512F__)
        using R [[maybe_unused]] = typename Register<L>::type;
        if constexpr (L == 8) a.r[k] = (R)_mm512_maskz_rcp14_pd(0xff, (__m512d)a.r[k]);
        else if constexpr (L == 4) a.r[k] = (R)_mm256_rcp14_pd((__m256d)a.r[k]);
        else a.r[k] = (R)_mm_rcp14_pd((__m128d)a.r[k]);
#else
        a.r[k] = 1.0 / a.r[k];
#endif
    }
    return a;
}

// 1 / a and 1 / sqrt(a) for a > 0, to about one unit in the last place. With AVX-512: an estimate of 14 bits and two steps of
// Newton's method take a fifth of the time of a division or a root.
template <int L, int K> STEP Pack<L, K> inverse(const Pack<L, K>& a) {
#if defined(__AVX512F__)
    Pack<L, K> y = rough_inverse(a);
    y = y + y * (1.0 - a * y);
    return y + y * (1.0 - a * y);
#else
    return 1.0 / a;
#endif
}
template <int L, int K> STEP Pack<L, K> inverse_sqrt(Pack<L, K> a) {
#if defined(__AVX512F__)
    for (int k = 0; k < K; ++k) {
        using R [[maybe_unused]] = typename Register<L>::type;
        const R half = 0.5 * a.r[k];
        R y;
        if constexpr (L == 8) y = (R)_mm512_rsqrt14_pd((__m512d)a.r[k]);
        else if constexpr (L == 4) y = (R)_mm256_rsqrt14_pd((__m256d)a.r[k]);
        else y = (R)_mm_rsqrt14_pd((__m128d)a.r[k]);
        y = y + y * (0.5 - half * y * y);
        a.r[k] = y + y * (0.5 - half * y * y);
    }
    return a;
#else
    return 1.0 / sqrt(a);
#endif
}
// sqrt(a) for a >= 0, to one unit in the last place.
template <int L, int K> STEP Pack<L, K> root(const Pack<L, K>& a) {
#if defined(__AVX512F__)
    const Pack<L, K> y = inverse_sqrt(a + 1e-300), s = a * y;
    return s + 0.5 * y * (a - s * s);
#else
    return sqrt(a);
#endif
}
// a / b for b > 0, to one unit in the last place.
template <int L, int K> STEP Pack<L, K> quotient(const Pack<L, K>& a, const Pack<L, K>& b) {
#if defined(__AVX512F__)
    const Pack<L, K> y = inverse(b), q = a * y;
    return q + y * (a - b * q);
#else
    return a / b;
#endif
}

template <int L, int K> STEP Pack<L, K> abs(Pack<L, K> a) {
    using B = typename Register<L>::bits;
    const B magnitude = B{} + 0x7fffffffffffffffLL;
    for (int k = 0; k < K; ++k) a.r[k] = (typename Register<L>::type)((B)a.r[k] & magnitude);
    return a;
}

// The leading 26 binary digits.
template <int L, int K> STEP Pack<L, K> upper_half(Pack<L, K> a) {
    using B = typename Register<L>::bits;
    const B leading = B{} + ~0x7ffffffLL;
    for (int k = 0; k < K; ++k) a.r[k] = (typename Register<L>::type)((B)a.r[k] & leading);
    return a;
}

// |a| with the sign of b.
template <int L, int K> STEP Pack<L, K> copysign(Pack<L, K> a, const Pack<L, K>& b) {
    using B = typename Register<L>::bits;
    const B magnitude = B{} + 0x7fffffffffffffffLL;
    for (int k = 0; k < K; ++k) a.r[k] = (typename Register<L>::type)(((B)a.r[k] & magnitude) | ((B)b.r[k] & ~magnitude));
    return a;
}

// ---- the same for one number ---------------------------------------------------------------------------------------

STEP double select(bool m, double a, double b) { return m ? a : b; }
STEP double min(double a, double b) { return a < b ? a : b; }
STEP double max(double a, double b) { return a > b ? a : b; }
STEP double sqrt(double a) { return __builtin_sqrt(a); }
STEP double inverse(double a) { return 1.0 / a; }
STEP double inverse_sqrt(double a) { return 1.0 / sqrt(a); }
STEP double root(double a) { return sqrt(a); }
STEP double quotient(double a, double b) { return a / b; }
STEP double abs(double a) { return __builtin_fabs(a); }
STEP double upper_half(double a) {
    return __builtin_bit_cast(double, __builtin_bit_cast(std::uint64_t, a) & ~std::uint64_t(0x7ffffff));
}
STEP double copysign(double a, double b) { return __builtin_copysign(a, b); }

// ---- memory ----------------------------------------------------------------------------------------------------------

// A pack from consecutive numbers in memory, and back.
template <class V> STEP V load(const double* from) {
    constexpr int K = int(sizeof(V::r) / sizeof(V::r[0])), L = V::lanes / K;
    V out;
    for (int k = 0; k < K; ++k) out.r[k] = *(const typename Register<L>::unaligned*)(from + L * k);
    return out;
}
template <int L, int K> STEP void store(const Pack<L, K>& a, double* to) {
    for (int k = 0; k < K; ++k) *(typename Register<L>::unaligned*)(to + L * k) = a.r[k];
}

// ---- rows to columns -------------------------------------------------------------------------------------------------

// L registers of L numbers, transposed.
template <int L> STEP void transpose(typename Register<L>::type (&r)[L]) {
    using R = typename Register<L>::type;
    if constexpr (L == 2) {
        const R a = __builtin_shufflevector(r[0], r[1], 0, 2), b = __builtin_shufflevector(r[0], r[1], 1, 3);
        r[0] = a, r[1] = b;
    } else if constexpr (L == 4) {
        const R a = __builtin_shufflevector(r[0], r[1], 0, 4, 2, 6), b = __builtin_shufflevector(r[0], r[1], 1, 5, 3, 7);
        const R c = __builtin_shufflevector(r[2], r[3], 0, 4, 2, 6), d = __builtin_shufflevector(r[2], r[3], 1, 5, 3, 7);
        r[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5), r[1] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
        r[2] = __builtin_shufflevector(a, c, 2, 3, 6, 7), r[3] = __builtin_shufflevector(b, d, 2, 3, 6, 7);
    } else {
        static_assert(L == 8);
        // Swap neighbouring numbers, then pairs, then fours.
        R s[8];
        for (int k = 0; k < 8; k += 2) {
            s[k] = __builtin_shufflevector(r[k], r[k + 1], 0, 8, 2, 10, 4, 12, 6, 14);
            s[k + 1] = __builtin_shufflevector(r[k], r[k + 1], 1, 9, 3, 11, 5, 13, 7, 15);
        }
        for (int k = 0; k < 8; k += 4) {
            for (int i = 0; i < 2; ++i) {
                r[k + i] = __builtin_shufflevector(s[k + i], s[k + 2 + i], 0, 1, 8, 9, 4, 5, 12, 13);
                r[k + 2 + i] = __builtin_shufflevector(s[k + i], s[k + 2 + i], 2, 3, 10, 11, 6, 7, 14, 15);
            }
        }
        for (int i = 0; i < 4; ++i) {
            const R a = r[i], b = r[4 + i];
            s[i] = __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11);
            s[4 + i] = __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15);
        }
        for (int i = 0; i < 8; ++i) r[i] = s[i];
    }
}

// N numbers to each lane's own place. Numbers that do not fill whole registers are stored twice at the end.
template <int N, int L> STEP void store_rows(const Pack<L, 1> (&from)[N], double* const (&to)[L]) {
    if constexpr (N < L) {
        in_turn<0, N>([&](auto i) IN_PLACE {
            for (int l = 0; l < L; ++l) to[l][i] = from[i][l];
        });
    } else {
        in_turn<0, (N + L - 1) / L>([&](auto part) IN_PLACE {
            constexpr int first = L * part + L <= N ? L * part : N - L;
            typename Register<L>::type r[L];
            in_turn<0, L>([&](auto i) IN_PLACE { r[i] = from[first + i].r[0]; });
            transpose<L>(r);
            in_turn<0, L>([&](auto l) IN_PLACE { *(typename Register<L>::unaligned*)(to[l] + first) = r[l]; });
        });
    }
}

// ---- the block of this instruction set: the number type V for batches --------------------------------------------------

#if defined(__AVX512F__)
using Block = Pack<8, 1>;
#elif defined(__AVX__)
using Block = Pack<4, 1>;
#else
using Block = Pack<2, 1>;
#endif
inline constexpr int BLOCK = Block::lanes;
// N numbers in the widest registers that they fill; N is a power of two.
inline constexpr int WIDEST = sizeof(Block::r[0]) / sizeof(double);
template <int N> using Row = Pack<(N < WIDEST ? N : WIDEST), (N < WIDEST ? 1 : N / WIDEST)>;

}  // namespace urdf_ik::URDF_IK_LEVEL
