// Trigonometric functions agree with the C library, also on both sides of each change of formula.
#include "numbers/trig.hpp"

#include "facts.hpp"

using namespace urdf_ik;
using namespace urdf_ik::URDF_IK_LEVEL;

// Half a unit in the last place of 1 is 1.1e-16.
constexpr double ULPS = 5e-16;

static void atan2_is_the_librarys() {
    for (int k = -2000; k <= 2000; ++k) {
        const double t = k * (PI / 2000.0), length = std::pow(10.0, k % 17 - 8);
        const double y = length * std::sin(t), x = length * std::cos(t);
        HOLDS(near(urdf_ik::URDF_IK_LEVEL::atan2(y, x), std::atan2(y, x), 2.0 * ULPS));
    }
    HOLDS(urdf_ik::URDF_IK_LEVEL::atan2(0.0, 0.0) == 0.0);
    HOLDS(urdf_ik::URDF_IK_LEVEL::atan2(0.0, -1.0) == PI);
    HOLDS(urdf_ik::URDF_IK_LEVEL::atan2(-0.0, -1.0) == -PI);
}

static void cosines_and_sines_are_the_librarys() {
    for (int k = -3000; k <= 3000; ++k) {
        const double a = 1.1 * PI * k / 3000.0;
        const Turn<double> t = cos_sin(a);
        HOLDS(near(t.c, std::cos(a), ULPS) && near(t.s, std::sin(a), ULPS));
    }
    // Large angles, on both sides of FAR, beyond which the C library is used.
    for (const double a : {1.0e3, -12345.678, FAR - 1.0, FAR + 1.0, 1e9, -1e15}) {
        const Turn<double> t = cos_sin_of_any(a);
        HOLDS(near(t.c, std::cos(a), 4.0 * ULPS) && near(t.s, std::sin(a), 4.0 * ULPS));
    }
}

// The error of a number beside one of more digits, in units in the last place of the latter.
static double ulps(double found, long double wanted) {
    const double size = std::abs(double(wanted));
    return double(std::abs(found - wanted)) / (std::nextafter(size, INFINITY) - size);
}

static void exact_functions_are_right_to_the_last_digit() {
    static_assert(sizeof(long double) > 8);
    for (int k = -20000; k <= 20000; ++k) {
        const double share = k / 20000.0, tiny = share * std::pow(10.0, k % 12), quarters = std::round(40.0 * share) * (PI / 4.0);
        for (const double a : {3.2 * share, tiny, std::nextafter(quarters, 0.0), 1e6 * share}) {
            const Turn<double> t = exact_turn(a);
            HOLDS(ulps(t.c, std::cos((long double)a)) < 1.0);
            HOLDS(ulps(t.s, std::sin((long double)a)) < 1.0);
        }
        for (const double x : {share, 40.0 * share, 690.0 * share}) {
            const double e = exponential(x);
            HOLDS(ulps(e, std::exp((long double)x)) < 0.7);
            HOLDS(ulps(logarithm(e), std::log((long double)e)) < 1.0);
        }
        HOLDS(near(urdf_ik::URDF_IK_LEVEL::acos(share), double(std::acos((long double)share)), 2.0 * ULPS));
    }
    HOLDS(exact_turn(0.0).c == 1.0 && exact_turn(0.0).s == 0.0 && exponential(0.0) == 1.0 && logarithm(1.0) == 0.0);
    HOLDS(exponential(701.0) == INFINITY && exponential(-701.0) == 0.0 && logarithm(0.0) == -INFINITY);
    HOLDS(logarithm(INFINITY) == INFINITY && std::isnan(logarithm(NAN)) && std::isnan(exponential(NAN)));
    HOLDS(std::isnan(exact_turn(INFINITY).c) && std::isnan(exact_turn(NAN).s));
}

static void angles_come_to_one_circle() {
    HOLDS(principal_angle(PI) == PI);
    HOLDS(principal_angle(-PI) == PI);
    HOLDS(near(principal_angle(7.0), 7.0 - 2.0 * PI, ULPS));
    HOLDS(near(wrap(4.0), 4.0 - 2.0 * PI, ULPS));
    for (const double a : {3.0, -3.0, 1e-300, -1e-300, 0.0, PI}) {
        const double b = half_turn_from(a);
        HOLDS(b > -PI && b <= PI);
        HOLDS(near(std::cos(b), -std::cos(a), ULPS));
    }
}

static void a_block_answers_as_a_number_does() {
    Block y, x;
    for (int i = 0; i < BLOCK; ++i) set_lane(y, i, std::sin(0.7 * i)), set_lane(x, i, std::cos(0.7 * i));
    const Block a = urdf_ik::URDF_IK_LEVEL::atan2(y, x);
    for (int i = 0; i < BLOCK; ++i) { HOLDS(near(lane(a, i), urdf_ik::URDF_IK_LEVEL::atan2(lane(y, i), lane(x, i)), ULPS)); }
}

void test_trig() {
    atan2_is_the_librarys();
    cosines_and_sines_are_the_librarys();
    exact_functions_are_right_to_the_last_digit();
    angles_come_to_one_circle();
    a_block_answers_as_a_number_does();
}
