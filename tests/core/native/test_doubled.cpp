// Numbers of twice the digits keep the identities of real numbers to 30 digits.
#include "numbers/doubled.hpp"

#include "facts.hpp"

using namespace urdf_ik::URDF_IK_LEVEL;

constexpr double DIGITS = 1e-31;

static double left(const Doubled& a) { return std::abs(a.hi); }

static void products_and_sums_keep_what_doubles_lose() {
    // (1 + e)^2 = 1 + 2 e + e^2, with e far below the rounding of one.
    for (int k = 30; k <= 50; ++k) {
        const Doubled e = std::ldexp(1.0, -k), x = Doubled(1.0) + e;
        HOLDS(left(x * x - Doubled(1.0) - 2.0 * e - e * e) <= DIGITS);
    }
    for (int k = 1; k <= 1000; ++k) {
        const Doubled a = std::sin(double(k)), b = std::cos(3.0 * k) * 1e-7;
        const Doubled difference = (a + b) * (a - b) - (a * a - b * b);
        HOLDS(left(difference) <= DIGITS);
    }
}

static void quotients_are_inverse_to_products() {
    for (int k = 1; k <= 1000; ++k) {
        const Doubled a = std::sin(double(k)), b = 0.1 * k;
        HOLDS(left(a / b * b - a) <= DIGITS);
    }
    const Doubled third = Doubled(1.0) / Doubled(3.0);
    HOLDS(left(third + third + third - Doubled(1.0)) <= DIGITS);
    HOLDS(third.hi == 1.0 / 3.0 && third.lo != 0.0);
}

static void roots_square_to_their_number() {
    for (int k = 2; k <= 1000; ++k) {
        const Doubled n = {double(k), 1e-17 * k}, x = sqrt(n);
        HOLDS(left(x * x - n) <= 4.0 * k * DIGITS);
    }
}

// A block does in each lane what one number does, to the last digit.
static void blocks_do_what_numbers_do() {
    using DoubledBlock = DoubledOf<Block>;
    for (int k = 1; k <= 200; ++k) {
        DoubledBlock a, b;
        Doubled x[BLOCK], y[BLOCK];
        for (int l = 0; l < BLOCK; ++l) {
            x[l] = Doubled(2.0 + std::sin(double(k + l))) / Doubled(3.0), y[l] = Doubled(std::cos(3.0 * k - l)) / Doubled(7.0);
            a.hi.set(l, x[l].hi), a.lo.set(l, x[l].lo), b.hi.set(l, y[l].hi), b.lo.set(l, y[l].lo);
        }
        const DoubledBlock many[] = {a + b, a - b, a * b, b / a, sqrt(a), Doubled(1.0, 1e-17) * a};
        for (int l = 0; l < BLOCK; ++l) {
            const Doubled one[] = {x[l] + y[l], x[l] - y[l], x[l] * y[l], y[l] / x[l], sqrt(x[l]), Doubled(1.0, 1e-17) * x[l]};
            for (int i = 0; i < 6; ++i) {
                HOLDS(std::abs(many[i].hi[l] - one[i].hi + (many[i].lo[l] - one[i].lo)) <= DIGITS * std::abs(one[i].hi));
            }
        }
    }
}

void test_doubled() {
    products_and_sums_keep_what_doubles_lose();
    quotients_are_inverse_to_products();
    roots_square_to_their_number();
    blocks_do_what_numbers_do();
}
