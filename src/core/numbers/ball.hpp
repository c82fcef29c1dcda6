// Numbers with a bound on their error: the steps of the closed forms run on balls as they run on numbers, and the ball of a result
// then holds the exact result of all numbers that the balls of its arguments hold.
//
// Rounding: let u = 2^-53. An operation on centres errs by at most u |result|. A constant that was itself rounded (a reciprocal)
// adds as much again, so ROUNDED = 2 u a step bounds both; a root or a reciprocal root of a pack errs by up to 2 u and takes
// 2 ROUNDED. Radii are sums, products, quotients and roots of numbers that are not negative: each operation loses at most the
// factor 1 - 2 u, a chain of 10^5 operations 1 - 3e-11. INFLATED makes up for that wherever a radius is compared or subtracted.
// A fused multiply-add rounds once instead of twice. Numbers below 1e-290 are not considered.
#pragma once

#include <type_traits>

#include "numbers/trig.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

inline constexpr double ROUNDED = 2.3e-16, INFLATED = 1.0 + 1e-9;

// What follows from the other operations of a number with bounds. centre(): comparisons are between centres, as they choose
// between formulas that both hold.
template <class N> struct Bounded {
    friend STEP N operator/(const N& a, const N& b) { return a * reciprocal(b); }
    friend STEP N operator/(double a, const N& b) { return a * reciprocal(b); }
    friend STEP N operator+(double a, const N& b) { return b + a; }
    friend STEP N operator*(double a, const N& b) { return b * a; }
    friend STEP N operator-(const N& a, double b) { return a + -b; }
    friend STEP N operator-(double a, const N& b) { return -b + a; }
    friend STEP auto operator<(const N& a, const N& b) { return a.centre() < b.centre(); }
    friend STEP auto operator>(const N& a, const N& b) { return a.centre() > b.centre(); }
    friend STEP auto operator<=(const N& a, const N& b) { return a.centre() <= b.centre(); }
    friend STEP auto operator>=(const N& a, const N& b) { return a.centre() >= b.centre(); }
};

template <class V> struct Ball : Bounded<Ball<V>> {
    V mid, rad;

    Ball() = default;
    STEP Ball(double x) : mid(x), rad(0.0) {}
    STEP explicit Ball(const V& exact)
        requires(!std::is_same_v<V, double>)
        : mid(exact), rad(0.0) {}
    STEP Ball(const V& centre, const V& radius) : mid(centre), rad(radius) {}

    friend STEP Ball operator+(const Ball& a, const Ball& b) { return rounded(a.mid + b.mid, a.rad + b.rad); }
    friend STEP Ball operator-(const Ball& a, const Ball& b) { return rounded(a.mid - b.mid, a.rad + b.rad); }
    friend STEP Ball operator*(const Ball& a, const Ball& b) {
        return rounded(a.mid * b.mid, abs(a.mid) * b.rad + a.rad * (abs(b.mid) + b.rad));
    }
    friend STEP Ball operator+(const Ball& a, double b) { return rounded(a.mid + b, a.rad); }
    friend STEP Ball operator*(const Ball& a, double b) { return rounded(a.mid * b, a.rad * __builtin_fabs(b)); }
    friend STEP Ball operator-(const Ball& a) { return {-a.mid, a.rad}; }
    // |1 / (b + e) - 1 / b| <= |e| / (|b| (|b| - |e|)); a ball that holds zero has no reciprocal.
    friend STEP Ball reciprocal(const Ball& b) {
        const V size = abs(b.mid), over = 1.0 / b.mid, left = size - INFLATED * b.rad;
        const V spread = select(left > V(0.0), b.rad * abs(over) / left, V(__builtin_inf()));
        return {over, spread + 2.0 * ROUNDED * abs(over)};
    }

    STEP const V& centre() const { return mid; }
    // The least and the greatest number in the ball.
    STEP V least() const { return mid - INFLATED * rad; }
    STEP V greatest() const { return mid + INFLATED * rad; }

private:
    static STEP Ball rounded(const V& at, const V& radius) { return {at, radius + ROUNDED * abs(at)}; }
};

// Functions with slopes of at most one keep the radius.
template <class V> STEP Ball<V> abs(const Ball<V>& a) { return {abs(a.mid), a.rad}; }
template <class V> STEP Ball<V> max(const Ball<V>& a, const Ball<V>& b) { return {max(a.mid, b.mid), max(a.rad, b.rad)}; }
template <class V> STEP Ball<V> min(const Ball<V>& a, const Ball<V>& b) { return {min(a.mid, b.mid), max(a.rad, b.rad)}; }
template <class V> STEP Ball<V> max(const Ball<V>& a, double b) { return {max(a.mid, V(b)), a.rad}; }
template <class V> STEP Ball<V> min(const Ball<V>& a, double b) { return {min(a.mid, V(b)), a.rad}; }
template <class M, class V> STEP Ball<V> select(const M& m, const Ball<V>& a, const Ball<V>& b) {
    return {select(m, a.mid, b.mid), select(m, a.rad, b.rad)};
}
// |a| with the sign of b, whose ball does not hold zero.
template <class V> STEP Ball<V> copysign(const Ball<V>& a, const Ball<V>& b) { return {copysign(abs(a.mid), b.mid), a.rad}; }

// The roots of all numbers in the ball that are not negative. A ball that a division has left without bounds stays so: max() is its
// second argument if either is NaN.
template <class V> STEP Ball<V> root(const Ball<V>& a) {
    const V low = root(max(V(0.0), a.least())), high = root(max(V(0.0), a.greatest()));
    return {0.5 * (high + low), 0.5 * (high - low) + 2.0 * ROUNDED * high};
}

// The root of a margin: of a ball's part that is not negative.
template <class V> STEP Ball<V> margin_root(const Ball<V>& margin) { return root(margin); }

// (c, s) scaled to length 1. A disc of radius d about a vector of length n is seen from the origin under angles of up to
// asin(d / n); the chord of asin(x) is sqrt(2 - 2 sqrt(1 - x^2)) <= x (1 + 0.4143 x^2) for x in [0, 1]. A disc that holds the
// origin gives the whole circle: the ball of radius 1 about the origin.
template <class V> STEP Turn<Ball<V>> unit(const Ball<V>& c, const Ball<V>& s) {
    const V over = inverse_sqrt(c.mid * c.mid + s.mid * s.mid + TINY);
    const V x = root(c.rad * c.rad + s.rad * s.rad) * over * INFLATED;
    const auto arc = x < V(1.0);
    const V chord = select(arc, x + 0.4143 * x * x * x + 4.0 * ROUNDED, V(1.0));
    return {{select(arc, c.mid * over, V(0.0)), chord}, {select(arc, s.mid * over, V(0.0)), chord}};
}

}  // namespace urdf_ik::URDF_IK_LEVEL
