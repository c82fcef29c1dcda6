// Numbers that change with a parameter t in [-1, 1], with bounds: the steps of the closed forms run on them as they run on balls.
//
// A ball (ball.hpp) treats the arguments of an operation as independent, so a result is too wide by a share of its arguments'
// widths. Here each number holds a(0), a slope and a(t), each as a ball: a(t) - a(0) is the slope's centre times t, within its
// radius. Slopes follow from those of the arguments (Krawczyk and Neumaier 1985), for instance
//   a b:  a(t) b(t) - a(0) b(0) = a(t) (b(t) - b(0)) + (a(t) - a(0)) b(0)
// since |t| <= 1: a ball of factors k, times m t within r, is k's centre times m t, within what the product of balls gives. a(t) is
// within |slope| of a(0), too, which is too wide by squares of widths only. Whatever else the arguments depend on is the same in
// a(0) and in a(t).
#pragma once

#include "arithmetic/ball.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

template <class V> struct Slanted : Bounded<Slanted<V>> {
    using B = Ball<V>;
    B at, slope, all;  // a(0), a(t) - a(0), a(t)

    Slanted() = default;
    STEP Slanted(double x) : at(x), slope(0.0), all(x) {}
    STEP explicit Slanted(const V& exact)
        requires(!std::is_same_v<V, double>)
        : at(exact), slope(0.0), all(exact) {}
    STEP Slanted(const B& fixed) : at(fixed), slope(0.0), all(fixed) {}
    // Where a slope says no more than `all`, the change is what `all` bounds.
    STEP Slanted(const B& start, const B& change, const B& range) : at(start), slope(change), all(range) {
        const V most = INFLATED * (at.rad + abs(slope.mid) + slope.rad);
        const auto tighter = most < all.rad;
        all = {select(tighter, at.mid, all.mid), select(tighter, most, all.rad)};
        const V apart = INFLATED * (abs(all.mid - at.mid) + all.rad + at.rad);
        const auto known = slope.rad <= apart;
        slope = {select(known, slope.mid, V(0.0)), select(known, slope.rad, apart)};
    }

    friend PART Slanted operator+(const Slanted& a, const Slanted& b) { return {a.at + b.at, a.slope + b.slope, a.all + b.all}; }
    friend PART Slanted operator-(const Slanted& a, const Slanted& b) { return {a.at - b.at, a.slope - b.slope, a.all - b.all}; }
    friend PART Slanted operator*(const Slanted& a, const Slanted& b) {
        return {a.at * b.at, a.all * b.slope + a.slope * b.at, a.all * b.all};
    }
    friend STEP Slanted operator+(const Slanted& a, double b) { return {a.at + b, a.slope, a.all + b}; }
    friend PART Slanted operator*(const Slanted& a, double b) { return {a.at * b, a.slope * b, a.all * b}; }
    friend STEP Slanted operator/(const Slanted& a, double b) { return a * (1.0 / b); }
    friend STEP Slanted operator-(const Slanted& a) { return {-a.at, -a.slope, -a.all}; }
    friend STEP Slanted reciprocal(const Slanted& b) {
        const B over = reciprocal(b.at), over_all = reciprocal(b.all);
        return {over, -(b.slope * over) * over_all, over_all};
    }

    STEP const V& centre() const { return all.mid; }
    STEP V least() const { return all.least(); }
    STEP V greatest() const { return all.greatest(); }
};

// One of two as it stands: a cosine and a sine whose ranges are one disc must not be narrowed each for itself.
template <class V> STEP Slanted<V> select(const auto& m, const Slanted<V>& a, const Slanted<V>& b) {
    Slanted<V> out;
    out.at = select(m, a.at, b.at), out.slope = select(m, a.slope, b.slope), out.all = select(m, a.all, b.all);
    return out;
}
template <class V> STEP Slanted<V> abs(const Slanted<V>& a) {
    const V most = abs(a.slope.mid) + a.slope.rad;
    return {abs(a.at), {V(0.0), most}, abs(a.all)};
}
// A maximum changes by what lies between those of both numbers.
template <class V> STEP Ball<V> either(const Ball<V>& a, const Ball<V>& b) {
    const V middle = 0.5 * (a.mid + b.mid), half = 0.5 * abs(a.mid - b.mid);
    return {middle, half + max(a.rad, b.rad) + ROUNDED * (abs(middle) + half)};
}
template <class V> STEP Slanted<V> max(const Slanted<V>& a, const Slanted<V>& b) {
    const Slanted<V> out = {max(a.at, b.at), either(a.slope, b.slope), max(a.all, b.all)};
    const auto first = (a.all.least() > b.all.greatest()) & (a.at.least() > b.at.greatest());
    const auto second = (b.all.least() > a.all.greatest()) & (b.at.least() > a.at.greatest());
    return select(first, a, select(second, b, out));
}
template <class V> STEP Slanted<V> min(const Slanted<V>& a, const Slanted<V>& b) { return -max(-a, -b); }
template <class V> STEP Slanted<V> max(const Slanted<V>& a, double b) { return max(a, Slanted<V>(b)); }
template <class V> STEP Slanted<V> min(const Slanted<V>& a, double b) { return min(a, Slanted<V>(b)); }
// |a| with the sign of b, which is the same everywhere.
template <class V> STEP Slanted<V> copysign(const Slanted<V>& a, const Slanted<V>& b) {
    const V one = copysign(V(1.0), b.all.mid);
    return Slanted<V>(one) * abs(a);
}

// The roots of what is not negative: where a number may be, its slope is left to its range.
template <class V> PART Slanted<V> root(const Slanted<V>& a) {
    const Ball<V> start = root(a.at), range = root(a.all), slope = a.slope / (start + range);
    const auto positive = (a.all.least() > V(0.0)) & (a.at.least() > V(0.0));
    return {start, {slope.mid, select(positive, slope.rad, V(__builtin_inf()))}, range};
}
template <class V> STEP Slanted<V> margin_root(const Slanted<V>& margin) { return root(margin); }

// (c, s) scaled to length 1; c.all and s.all are one disc. From t = 0 on the direction turns by an angle whose sine is
// x = (c(0) s(t) - s(0) c(t)) / (|.| |.|), up to 90 degrees while the vector moves by less than its length, and it changes by
// x across itself, less at most x^2 (1 + x^2) / 2 along itself.
template <class V> PART Turn<Slanted<V>> unit(const Slanted<V>& c, const Slanted<V>& s) {
    using B = Ball<V>;
    const Turn<B> start = unit(c.at, s.at), range = unit(c.all, s.all);
    const B length = root(c.at * c.at + s.at * s.at), lengths = length * root(c.all * c.all + s.all * s.all);
    const B x = (c.at * s.slope - s.at * c.slope) / lengths;
    const V moved_c = abs(c.slope.mid) + c.slope.rad, moved_s = abs(s.slope.mid) + s.slope.rad;
    const V most = INFLATED * (abs(x.mid) + x.rad), least = length.least();
    const auto small = (INFLATED * (moved_c * moved_c + moved_s * moved_s) < least * least) & (least > V(0.0)) & (most < V(1.0));
    const B less = {V(0.0), 0.5 * most * most * (1.0 + most * most)};
    const V none = select(small, V(0.0), V(__builtin_inf()));
    const B change_c = less - start.s * x, change_s = less + start.c * x;
    const V chord = INFLATED * (start.c.rad + most * (1.0 + 0.4143 * most * most));
    const auto tighter = small & (chord < range.c.rad);
    const B all_c = {select(tighter, start.c.mid, range.c.mid), select(tighter, chord, range.c.rad)};
    const B all_s = {select(tighter, start.s.mid, range.s.mid), select(tighter, chord, range.s.rad)};
    Turn<Slanted<V>> out = {{start.c, {change_c.mid, change_c.rad + none}, all_c},
                            {start.s, {change_s.mid, change_s.rad + none}, all_s}};
    out.c.all = all_c, out.s.all = all_s;
    return out;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
