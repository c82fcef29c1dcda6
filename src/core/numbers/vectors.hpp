// Vectors, rotations, rigid motions and twists, of numbers or packs.
#pragma once

#include "numbers/trig.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

template <class V> struct Vec {
    V x, y, z;
};
template <class V> STEP Vec<V> operator+(const Vec<V>& a, const Vec<V>& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
template <class V> STEP Vec<V> operator-(const Vec<V>& a, const Vec<V>& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
template <class V> STEP Vec<V> operator*(const V& f, const Vec<V>& a) { return {f * a.x, f * a.y, f * a.z}; }
template <class V> STEP V dot(const Vec<V>& a, const Vec<V>& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
template <class V> STEP Vec<V> cross(const Vec<V>& a, const Vec<V>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class V> STEP Vec<V> vec(const double (&a)[3]) { return {V(a[0]), V(a[1]), V(a[2])}; }

// A rotation by its columns.
template <class V> struct Rot {
    Vec<V> x, y, z;
};
template <class V> STEP Vec<V> operator*(const Rot<V>& R, const Vec<V>& a) {
    return {R.x.x * a.x + R.y.x * a.y + R.z.x * a.z, R.x.y * a.x + R.y.y * a.y + R.z.y * a.z,
            R.x.z * a.x + R.y.z * a.y + R.z.z * a.z};
}

// A frame: its axes and its origin.
template <class V> struct Frame {
    Rot<V> R;
    Vec<V> p;
};

// A constant rotation, given by rows, times a vector.
template <class V> STEP Vec<V> times(const double (&R)[3][3], const Vec<V>& a) {
    return {R[0][0] * a.x + R[0][1] * a.y + R[0][2] * a.z, R[1][0] * a.x + R[1][1] * a.y + R[1][2] * a.z,
            R[2][0] * a.x + R[2][1] * a.y + R[2][2] * a.z};
}
// A rotation times one column of a constant one.
template <class V> STEP Vec<V> combine(const Rot<V>& R, double a, double b, double c) {
    return {R.x.x * a + R.y.x * b + R.z.x * c, R.x.y * a + R.y.y * b + R.z.y * c, R.x.z * a + R.y.z * b + R.z.z * c};
}

// A rotation times a constant one, given by rows.
template <class V> STEP Rot<V> operator*(const Rot<V>& R, const double (&L)[3][3]) {
    return {combine(R, L[0][0], L[1][0], L[2][0]), combine(R, L[0][1], L[1][1], L[2][1]), combine(R, L[0][2], L[1][2], L[2][2])};
}
// f(column) of each column.
template <class V, class F> STEP Rot<V> each(const Rot<V>& R, const F& f) { return {f(R.x), f(R.y), f(R.z)}; }

// The frame turned about its own z axis.
template <class V> STEP Frame<V> turned(const Frame<V>& at, const Turn<V>& t) {
    return {{t.c * at.R.x + t.s * at.R.y, t.c * at.R.y - t.s * at.R.x, at.R.z}, at.p};
}

// A vector or a rotation turned about unit h.
STEP Vec<double> turned_about(const Vec<double>& v, const Vec<double>& h, const Turn<double>& t) {
    return t.c * v + t.s * cross(h, v) + ((1.0 - t.c) * dot(h, v)) * h;
}
STEP Rot<double> turned_about(const Rot<double>& R, const Vec<double>& h, const Turn<double>& t) {
    return {turned_about(R.x, h, t), turned_about(R.y, h, t), turned_about(R.z, h, t)};
}

// A column of numbers: a twist or a column of the Jacobian, linear part first, with further rows for an arm's other constraints.
template <int R, class V> struct Rows {
    V v[R];
    STEP V& operator[](int i) { return v[i]; }
    STEP const V& operator[](int i) const { return v[i]; }
};
template <class V> using Six = Rows<6, V>;
template <int R, class V> STEP V dot(const Rows<R, V>& a, const Rows<R, V>& b) {
    V sum = a[0] * b[0];
    for (int i = 1; i < R; ++i) sum += a[i] * b[i];
    return sum;
}
// The same in two sums that do not wait for each other.
template <int R, class V> STEP V dot_in_two(const Rows<R, V>& a, const Rows<R, V>& b) {
    V even = a[0] * b[0], odd = a[1] * b[1];
    in_turn<1, R / 2>([&](auto i) IN_PLACE { even += a[2 * i] * b[2 * i], odd += a[2 * i + 1] * b[2 * i + 1]; });
    if constexpr (R % 2) even += a[R - 1] * b[R - 1];
    return even + odd;
}
template <int R, class V> STEP Rows<R, V> times(Rows<R, V> a, const V& f) {
    for (auto& x : a.v) x = x * f;
    return a;
}
template <int R, class V> STEP Rows<R, V> less(Rows<R, V> a, const V& f, const Rows<R, V>& b) {
    for (int i = 0; i < R; ++i) a[i] = a[i] - f * b[i];
    return a;
}
template <int R, class V> STEP V largest(const Rows<R, V>& a) {
    V most = abs(a[0]);
    for (int i = 1; i < R; ++i) most = max(most, abs(a[i]));
    return most;
}

// (x, y) turned back by the angle t.
template <class V, class W> STEP void unturn(V& x, V& y, const Turn<W>& t) {
    const V turned_x = t.c * x + t.s * y;
    y = t.c * y - t.s * x;
    x = turned_x;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
