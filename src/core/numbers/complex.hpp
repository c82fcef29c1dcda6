// Complex numbers, of doubles or packs: only the operations that kinematics needs.
#pragma once

#include "numbers/vectors.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Numbers whose operations are calls: so are those of complex ones.
template <class V> inline constexpr bool IS_CALLED = false;

template <class V> struct Complexes {
    V re, im;
    Complexes() = default;
    STEP Complexes(double x) : re(x), im(0.0) {}
    STEP Complexes(const V& x, const V& y) : re(x), im(y) {}

    friend STEP Complexes operator+(const Complexes& a, const Complexes& b) { return {a.re + b.re, a.im + b.im}; }
    friend STEP Complexes operator-(const Complexes& a, const Complexes& b) { return {a.re - b.re, a.im - b.im}; }
    friend STEP Complexes operator-(const Complexes& a) { return {-a.re, -a.im}; }
    friend STEP Complexes operator*(const Complexes& a, const Complexes& b) {
        if constexpr (IS_CALLED<V>) return called_product(a, b);
        else return product(a, b);
    }
    friend STEP Complexes operator*(double f, const Complexes& a) { return {f * a.re, f * a.im}; }
    friend STEP Complexes operator*(const Complexes& a, double f) { return f * a; }
    STEP Complexes& operator+=(const Complexes& b) { return *this = *this + b; }
    STEP Complexes& operator-=(const Complexes& b) { return *this = *this - b; }

private:
    static STEP Complexes product(const Complexes& a, const Complexes& b) {
        return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
    }
    static PART Complexes called_product(const Complexes& a, const Complexes& b) { return product(a, b); }
};

template <class V> STEP Complexes<V> scaled(const V& f, const Complexes<V>& a) { return {f * a.re, f * a.im}; }
template <class V> STEP Complexes<V> conj(const Complexes<V>& a) { return {a.re, -a.im}; }
template <class V> STEP V square(const Complexes<V>& a) { return a.re * a.re + a.im * a.im; }
template <class V> STEP Complexes<V> inverse(const Complexes<V>& a) {
    const V w = V(1.0) / (square(a) + TINY);
    return {a.re * w, -(a.im * w)};
}
template <class V> STEP Complexes<V> select(const MaskOf<V>& m, const Complexes<V>& a, const Complexes<V>& b) {
    return {select(m, a.re, b.re), select(m, a.im, b.im)};
}

// e^(i a), for |a| up to about 0.5: error below 2e-6, its Taylor series up to the sixth power.
template <class V> STEP Complexes<V> small_turn(const Complexes<V>& a) {
    const Complexes<V> x = {-a.im, a.re};  // i a
    Complexes<V> sum = 1.0;
    for (int k = 6; k > 0; --k) sum = Complexes<V>(1.0) + (1.0 / k) * (x * sum);
    return sum;
}

// The cosine and sine of an angle, from e^(i angle).
template <class V> STEP Turn<Complexes<V>> turn_of(const Complexes<V>& z) {
    const Complexes<V> w = inverse(z), sum = 0.5 * (z + w), difference = 0.5 * (z - w);
    return {sum, {difference.im, -difference.re}};
}

}  // namespace urdf_ik::URDF_IK_LEVEL
