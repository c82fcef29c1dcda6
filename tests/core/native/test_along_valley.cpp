// The zeros of a function that is known up to an error are counted: every zero that the error leaves certain, and no other.
#include "certificate/along_valley.hpp"

#include "facts.hpp"

using namespace urdf_ik::URDF_IK_LEVEL;

constexpr double ROUNDED_F = 2e-14;  // of the function

// factor times the product of t - root.
static Valley with_zeros(double factor, std::initializer_list<double> roots, double constant = 0.0) {
    Valley out = {};
    int degree = 0;
    out.value[0][0] = factor;
    for (const double root : roots) {
        for (int n = ++degree; n > 0; --n) out.value[0][n] = out.value[0][n - 1] - root * out.value[0][n];
        out.value[0][0] *= -root;
    }
    out.value[0][0] += constant;
    return out;
}
// The error is the rounding, and grows with t as what is beyond a series does.
static Reduced bounds_with(double error) {
    Reduced out = {};
    double R = 0.1;
    for (int k = 0; k < Reduced::most; ++k, R *= 0.75) {
        out.radius[out.many] = R, out.error[out.many++] = error + 1e-12 * std::pow(R / 0.1, 9);
    }
    out.along = out.radius[1], out.across = 0.01;
    return out;
}
static int count(const Crossings& found, bool single) {
    int sum = 0;
    for (int i = 0; i < found.many; ++i) sum += found.at[i].single == single;
    return sum;
}
static bool has_zero(const Crossings& found, double at, double within) {
    for (int i = 0; i < found.many; ++i) {
        const Crossing& each = found.at[i];
        if (each.low <= at && at <= each.high && near(each.t, at, within)) return true;
    }
    return false;
}

static void zeros_are_found_however_many() {
    for (const double factor : {1.0, -1e-2, 1e-4}) {
        for (const double shift : {-7e-3, 0.0, 4e-4}) {
            const Valley f = with_zeros(factor, {shift - 5e-3, shift, shift + 2e-3, 0.03, -0.02});
            Crossings found;
            HOLDS(crossings_of(f, bounds_with(factor == 1e-4 ? 1e-18 : 1e-16), ROUNDED_F, found));
            HOLDS(count(found, true) == 5 && count(found, false) == 0);
            for (const double each : {shift - 5e-3, shift, shift + 2e-3, 0.03, -0.02}) HOLDS(has_zero(found, each, 1e-9));
        }
    }
}
static void zeros_that_rounding_does_not_separate_are_one() {
    Crossings found;
    HOLDS(crossings_of(with_zeros(1e-7, {0.01, 0.01}), bounds_with(ROUNDED_F), ROUNDED_F, found));
    HOLDS(found.many == 1 && !found.at[0].single && near(found.at[0].t, 0.01, 1e-6));
    HOLDS(crossings_of(with_zeros(1e-7, {0.01, 0.01 + 1e-4}), bounds_with(ROUNDED_F), ROUNDED_F, found));
    HOLDS(found.many == 1 && !found.at[0].single);
    HOLDS(crossings_of(with_zeros(1e-7, {0.01, 0.013}), bounds_with(ROUNDED_F), ROUNDED_F, found));
    HOLDS(count(found, true) == 2 && found.many == 2);
    // A single one stays certain beside them.
    HOLDS(crossings_of(with_zeros(1e-5, {0.01, 0.01, -0.02}), bounds_with(ROUNDED_F), ROUNDED_F, found));
    HOLDS(count(found, true) == 1 && count(found, false) == 1 && has_zero(found, -0.02, 1e-5));
}
static void a_minimum_that_all_but_keeps_the_pose_is_represented() {
    Crossings found;
    HOLDS(crossings_of(with_zeros(1e-7, {2e-3, 2e-3}, 1e-11), bounds_with(ROUNDED_F), ROUNDED_F, found));
    HOLDS(found.many == 1 && !found.at[0].single && near(found.at[0].t, 2e-3, 1e-5));
    // Not where it misses the pose by more, nor between two zeros, where |F| has a maximum.
    HOLDS(crossings_of(with_zeros(1e-7, {2e-3, 2e-3}, 1e-9), bounds_with(ROUNDED_F), ROUNDED_F, found));
    HOLDS(found.many == 0);
    HOLDS(crossings_of(with_zeros(1e-7, {2e-3, 2e-3}, -1e-11), bounds_with(ROUNDED_F), ROUNDED_F, found));
    HOLDS(found.many == 2 && count(found, true) == 2);
}
static void no_zero_lies_at_an_end() {
    for (int k = 0; k < 60; ++k) {
        const double root = 0.02 + 0.001 * k;
        const Valley f = with_zeros(1e-6, {root, -0.01});
        const Reduced bounds = bounds_with(ROUNDED_F);
        Crossings found;
        HOLDS(crossings_of(f, bounds, ROUNDED_F, found));
        HOLDS(found.low >= -bounds.along && found.high <= bounds.along);
        for (const double each : {root, -0.01}) {
            const bool inside = found.low < each && each < found.high;
            HOLDS(has_zero(found, each, 1e-5) == inside);
            HOLDS(std::fabs(each - found.low) > AT_AN_END && std::fabs(each - found.high) > AT_AN_END);
        }
    }
}
static void where_all_is_rounding_there_is_no_piece() {
    Crossings found;
    HOLDS(!crossings_of(with_zeros(1e-14, {0.01}), bounds_with(ROUNDED_F), ROUNDED_F, found));
    // Nor where the bounds are too wide to tell.
    HOLDS(!crossings_of(with_zeros(1e-8, {0.0}), bounds_with(1e-9), ROUNDED_F, found));
}

void test_along_valley() {
    zeros_are_found_however_many();
    zeros_that_rounding_does_not_separate_are_one();
    a_minimum_that_all_but_keeps_the_pose_is_represented();
    no_zero_lies_at_an_end();
    where_all_is_rounding_there_is_no_piece();
}
