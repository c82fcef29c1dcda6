// Trigonometric functions agree with the C library, also on both sides of each change of formula.
#include "arithmetic/trig.hpp"

#include "facts.hpp"

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

static void angles_come_to_one_circle() {
    HOLDS(on_circle(PI) == PI);
    HOLDS(on_circle(-PI) == PI);
    HOLDS(near(on_circle(7.0), 7.0 - 2.0 * PI, ULPS));
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
    angles_come_to_one_circle();
    a_block_answers_as_a_number_does();
}
