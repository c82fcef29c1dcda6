// Facts about the zeros of two functions of two numbers, known up to a bound; see certificate/on_surface.hpp.
#include "certificate/on_surface.hpp"

#include "facts.hpp"

using namespace urdf_ik::URDF_IK_LEVEL;

constexpr double ROUNDED_F = 2e-14;  // of the functions

static Reduced bounds_with(double error) {
    Reduced out = {};
    double R = 0.1;
    for (int k = 0; k < Reduced::most; ++k, R *= 0.75) {
        out.radius[out.many] = R, out.error[out.many++] = error + 1e-12 * std::pow(R / 0.1, 7);
    }
    out.along = out.radius[1], out.across = 0.01;
    return out;
}
// Products of (t_1 - a) and of (t_2 - b), mixed so that both functions depend on both numbers.
static OnSurface with_zeros(double factor, const double (&a)[2], const double (&b)[2], double mix, double constant = 0.0) {
    OnSurface out = {};
    const auto set = [&](int o, double by) {
        const int one = o ? 2 : 1, square_place = o ? term_of<2>(2, 2) : term_of<2>(2, 0);
        const double (&r)[2] = o ? b : a;
        for (int to = 0; to < 2; ++to) {
            double (&q)[TERMS<2>] = out.value[to];
            const double f = by * (to == o ? 1.0 : to ? mix : -mix);
            q[0] += f * (r[0] * r[1] + (o ? constant : 0.0)), q[one] -= f * (r[0] + r[1]), q[square_place] += f;
        }
    };
    set(0, factor), set(1, factor);
    return out;
}
static double value_of(const OnSurface& f, int o, const double (&t)[2], double (&slope)[2]) {
    double sum = 0.0;
    slope[0] = slope[1] = 0.0;
    for (int n = 0; n <= ORDERS<2>; ++n) {
        for (int b = 0; b <= n; ++b) {
            const double c = f.value[o][term_of<2>(n, b)];
            const int a = n - b;
            sum += c * std::pow(t[0], a) * std::pow(t[1], b);
            if (a) slope[0] += c * a * std::pow(t[0], a - 1) * std::pow(t[1], b);
            if (b) slope[1] += c * b * std::pow(t[0], a) * std::pow(t[1], b - 1);
        }
    }
    return sum;
}
static int count(const Zeros& found, bool single) {
    int sum = 0;
    for (int i = 0; i < found.many; ++i) sum += found.at[i].single == single;
    return sum;
}
static bool has_zero(const Zeros& found, double x, double y, double within) {
    for (int i = 0; i < found.many; ++i) {
        if (near(found.at[i].t[0], x, within) && near(found.at[i].t[1], y, within)) return true;
    }
    return false;
}

static void four_zeros_are_found_however_near() {
    for (const double apart : {1e-2, 1e-3, 3e-5}) {
        for (const double mix : {0.0, 0.4, -0.9}) {
            for (const double middle : {0.0, 4e-3}) {
                const double a[2] = {middle - apart, middle + apart}, b[2] = {-0.7 * apart, 0.7 * apart};
                Zeros found;
                HOLDS(zeros_on_surface(with_zeros(1.0, a, b, mix), bounds_with(1e-15), ROUNDED_F, 1e-3, found));
                HOLDS(count(found, true) == 4 && found.many == 4);
                for (const double x : a) {
                    for (const double y : b) HOLDS(has_zero(found, x, y, 1e-6 * apart + 1e-9));
                }
            }
        }
    }
}
static void zeros_that_rounding_does_not_separate_are_one() {
    Zeros found;
    const double same[2] = {2e-3, 2e-3}, other[2] = {1e-3, 1e-3}, apart[2] = {-3e-3, 3e-3};
    HOLDS(zeros_on_surface(with_zeros(1e-4, same, other, 0.3), bounds_with(ROUNDED_F), ROUNDED_F, 1e-3, found));
    HOLDS(found.many == 1 && !found.at[0].single && has_zero(found, 2e-3, 1e-3, 1e-4));
    HOLDS(zeros_on_surface(with_zeros(1e-2, same, apart, 0.3), bounds_with(ROUNDED_F), ROUNDED_F, 1e-3, found));
    HOLDS(found.many == 2 && count(found, false) == 2);
}
static void a_minimum_that_all_but_keeps_the_pose_is_represented() {
    Zeros found;
    const double a[2] = {-3e-3, 0.2}, b[2] = {1e-3, 1e-3};
    HOLDS(zeros_on_surface(with_zeros(1e-2, a, b, 0.0, 1e-9), bounds_with(ROUNDED_F), ROUNDED_F, 1e-3, found));
    HOLDS(found.many == 1 && !found.at[0].single && has_zero(found, -3e-3, 1e-3, 1e-3));
    HOLDS(zeros_on_surface(with_zeros(1e-2, a, b, 0.0, 1e-6), bounds_with(ROUNDED_F), ROUNDED_F, 1e-3, found));
    HOLDS(found.many == 0);
    HOLDS(zeros_on_surface(with_zeros(1e-2, a, b, 0.0, -1e-8), bounds_with(ROUNDED_F), ROUNDED_F, 1e-3, found));
    HOLDS(found.many == 2 && count(found, true) == 2);
}
// t_1 = 3 t_2^2 on a curve along which the other function has three zeros and is a thousandth of a millionth in between.
static void zeros_on_a_curve_are_counted() {
    for (const double mix : {0.0, 0.5}) {
        for (const bool turned : {false, true}) {
            OnSurface f = {};
            const auto term = [&](int n, int b) { return term_of<2>(n, turned ? n - b : b); };
            const double first[][3] = {{1, 0, 1e-2}, {2, 2, -3e-2}}, second[][3] = {{1, 1, -4e-9}, {3, 3, 1e-3}};
            for (const auto& [n, b, c] : first) f.value[0][term(n, b)] += c, f.value[1][term(n, b)] += mix * c;
            for (const auto& [n, b, c] : second) f.value[1][term(n, b)] += c;
            Zeros found;
            HOLDS(zeros_on_surface(f, bounds_with(1e-15), 1e-15, 5e-3, found));
            HOLDS(count(found, true) == 3 && found.many == 3);
            for (const double y : {-2e-3, 0.0, 2e-3}) {
                const double x = 3.0 * y * y;
                HOLDS(has_zero(found, turned ? y : x, turned ? x : y, 1e-5));
            }
        }
    }
}
// One function vanishes on a line, the other is rounding: what stands for the line lies in the square, and the line leaves it.
static void an_area_may_leave_the_square() {
    OnSurface f = {};
    f.value[0][1] = 1e-2, f.value[0][2] = 4e-3, f.value[1][2] = 1e-13;
    Zeros found;
    HOLDS(zeros_on_surface(f, bounds_with(1e-15), ROUNDED_F, 1e-3, found));
    HOLDS(found.many == 1 && !found.at[0].single && found.at[0].crosses);
    const Zero& each = found.at[0];
    HOLDS(near(each.t[0], -0.4 * each.t[1], 1e-9) && std::fabs(each.t[1]) < found.along);
}
// Newton's method from a grid finds no zero that is not known.
static void no_zero_is_missed() {
    unsigned state = 1;
    const auto random = [&] {
        state = state * 1664525u + 1013904223u;
        return (state >> 8) / 8388608.0 - 1.0;
    };
    int answers = 0, zeros = 0;
    for (int round = 0; round < 400; ++round) {
        // A slope in each direction, which may be small, curvatures, and terms of higher order.
        OnSurface f = {};
        const double weak[2] = {std::pow(10.0, 2.0 * random() - 4.0), std::pow(10.0, 2.0 * random() - 5.0)};
        for (int o = 0; o < 2; ++o) {
            f.value[o][0] = 3e-3 * weak[o] * random(), f.value[o][1 + o] = weak[o];
            for (int n = 2; n <= ORDERS<2>; ++n) {
                for (int b = 0; b <= n; ++b) f.value[o][term_of<2>(n, b)] = 0.1 * random();
            }
        }
        Zeros found;
        if (!zeros_on_surface(f, bounds_with(1e-15), ROUNDED_F, 1e-4, found)) continue;
        ++answers, zeros += found.many;
        for (int k = 0; k < 225; ++k) {
            double t[2] = {found.along * (k % 15 - 7) / 7.0, found.along * (k / 15 - 7) / 7.0}, v[2] = {1.0, 1.0};
            for (int step = 0; step < 40; ++step) {
                double slope[2][2];
                for (int o = 0; o < 2; ++o) v[o] = value_of(f, o, t, slope[o]);
                const double over = 1.0 / (slope[0][0] * slope[1][1] - slope[0][1] * slope[1][0]);
                t[0] -= over * (slope[1][1] * v[0] - slope[0][1] * v[1]), t[1] -= over * (slope[0][0] * v[1] - slope[1][0] * v[0]);
            }
            if (!(std::fabs(v[0]) + std::fabs(v[1]) < 1e-17) || !(std::fabs(t[0]) < found.along && std::fabs(t[1]) < found.along))
                continue;
            bool known = false;
            for (int i = 0; i < found.many; ++i) {
                const Zero& each = found.at[i];
                known |= near(t[0], each.in.c[0], each.in.reach(0) + 1e-9) && near(t[1], each.in.c[1], each.in.reach(1) + 1e-9);
            }
            HOLDS(known);
        }
    }
    HOLDS(answers > 200 && zeros > 200);
}

void test_on_surface() {
    four_zeros_are_found_however_near();
    zeros_that_rounding_does_not_separate_are_one();
    a_minimum_that_all_but_keeps_the_pose_is_represented();
    zeros_on_a_curve_are_counted();
    an_area_may_leave_the_square();
    no_zero_is_missed();
}
