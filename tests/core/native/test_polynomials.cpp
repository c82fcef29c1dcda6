// Known roots are found, and the polynomial vanishes at every returned root.
#include "numbers/quartic.hpp"

#include "facts.hpp"

using namespace urdf_ik;
using namespace urdf_ik::URDF_IK_LEVEL;

// (cos d1 - cos(t - m1)) (cos d2 - cos(t - m2)), whose roots are m1 +- d1 and m2 +- d2.
static TrigonometricPolynomial with_roots(double m1, double d1, double m2, double d2) {
    const double c1 = std::cos(d1), c2 = std::cos(d2);
    return {c1 * c2 + 0.5 * std::cos(m1 - m2), -c1 * std::cos(m2) - c2 * std::cos(m1), -c1 * std::sin(m2) - c2 * std::sin(m1),
            0.5 * std::cos(m1 + m2), 0.5 * std::sin(m1 + m2)};
}

static double value(const TrigonometricPolynomial& p, const Turn<double>& t) {
    return p.constant + p.cosine * t.c + p.sine * t.s + p.cosine2 * (t.c * t.c - t.s * t.s) + p.sine2 * 2.0 * t.s * t.c;
}

static bool has_root(const Quartic& found, double at, double within) {
    for (int k = 0; k < found.count; ++k) {
        if (std::fabs(std::remainder(angle(found.root[k]) - at, 2.0 * PI)) <= within) return true;
    }
    return false;
}

static void four_planted_roots_are_found() {
    for (int k = 0; k < 200; ++k) {
        const double m1 = 0.1 + 0.37 * k, d1 = 0.3 + 0.01 * (k % 40), m2 = m1 + 1.6 + 0.003 * k, d2 = 0.5;
        const TrigonometricPolynomial p = with_roots(m1, d1, m2, d2);
        const Quartic found = trigonometric_roots(p);
        HOLDS(found.count == 4);
        for (int i = 0; i < found.count; ++i) HOLDS(std::fabs(value(p, found.root[i])) < 1e-13);
        for (const double at : {m1 - d1, m1 + d1, m2 - d2, m2 + d2}) HOLDS(has_root(found, at, 1e-7));
    }
}

static void roots_come_in_the_order_of_their_angles() {
    const Quartic found = trigonometric_roots(with_roots(2.9, 0.7, -0.4, 1.1));
    for (int i = 1; i < found.count; ++i) HOLDS(angle(found.root[i - 1]) < angle(found.root[i]));
}

static void a_double_root_is_returned_twice() {
    // m2 +- 0 is one double root. Rounding may split it by the square root of the rounding error.
    const Quartic found = trigonometric_roots(with_roots(0.5, 1.0, 2.5, 0.0));
    HOLDS(found.count == 4);
    int at_the_double_root = 0;
    for (int i = 0; i < found.count; ++i) at_the_double_root += near(angle(found.root[i]), 2.5, 1e-6);
    HOLDS(at_the_double_root == 2);
}

static void a_polynomial_without_real_roots_has_none() {
    HOLDS(trigonometric_roots({3.0, 1.0, 0.5, 0.3, 0.2}).count == 0);
    HOLDS(trigonometric_roots({0.0, 0.0, 0.0, 0.0, 0.0}).count == 0);
}

static void without_a_second_harmonic_there_are_two_roots() {
    const Quartic found = trigonometric_roots({-0.5, 1.0, 0.0, 0.0, 0.0});
    HOLDS(found.count == 2);
    HOLDS(has_root(found, PI / 3.0, 1e-14) && has_root(found, -PI / 3.0, 1e-14));
}

// z^16 + 1 reads the same from both ends: its roots are the odd multiples of pi / 16 on the unit circle.
static void sixteen_roots_of_minus_one() {
    Complex c[17] = {}, z[16];
    c[0] = c[16] = {1.0, 0.0};
    self_inversive_roots<16>(c, z);
    for (int k = 0; k < 16; ++k) {
        bool found = false;
        const double at = (2 * k + 1) * PI / 16.0;
        for (const Complex& each : z) found |= std::hypot(each.re - std::cos(at), each.im - std::sin(at)) < 1e-14;
        HOLDS(found);
    }
}

void test_polynomials() {
    four_planted_roots_are_found();
    roots_come_in_the_order_of_their_angles();
    a_double_root_is_returned_twice();
    a_polynomial_without_real_roots_has_none();
    without_a_second_harmonic_there_are_two_roots();
    sixteen_roots_of_minus_one();
}
