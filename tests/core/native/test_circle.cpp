// Zeros on the circle are counted where they are: products of sines with chosen zeros, of which some lie close together and some
// beside the circle.
#include "certify/circle.hpp"

#include <vector>

#include "facts.hpp"

using namespace urdf_ik::URDF_IK_LEVEL;

namespace {

// A zero at re + i im, and at re - i im where im is not zero.
struct Zero {
    double re, im;
};

// The product of sin((theta - zero) / 2) over sixteen zeros, in numbers of twice the digits.
OnCircle<Doubled> polynomial(const std::vector<Zero>& zeros) {
    using C = Complexes<Doubled>;
    // Coefficients of e^(i k theta / 2), k = -16 to 16; sin(x / 2) ~ e^(i x / 2) - e^(-i x / 2).
    std::vector<C> c(1, C(1.0));
    int many = 0;
    const auto multiply = [&](double re, const Doubled& grow) {
        // e^(-i zero / 2) and its inverse: angles are moved by rounding.
        const Doubled x = std::cos(0.5 * re), y = std::sin(0.5 * re);
        const Doubled over = 1.5 - 0.5 * (x * x + y * y), a = over * x, b = over * y;
        const C up = {grow * a, -(grow * b)}, down = {a / grow, b / grow};
        std::vector<C> next(c.size() + 1, C(0.0));
        for (std::size_t k = 0; k < c.size(); ++k) next[k + 1] += c[k] * up, next[k] += -(c[k] * down);
        c = next, ++many;
    };
    for (const Zero& each : zeros) {
        const Doubled grow = std::exp(0.5 * each.im);
        multiply(each.re, grow);
        if (each.im != 0.0) multiply(each.re, 1.0 / grow);
    }
    HOLDS(many == 16);
    OnCircle<Doubled> p;
    for (int k = 0; k <= 8; ++k) p.re[k] = c[8 + k].re, p.im[k] = c[8 + k].im;
    // Conjugates are equal to the last digits.
    HOLDS(std::abs(p.im[0].hi) <= 1e-29 * std::abs(p.re[0].hi) + 1e-26);
    p.error = 1e-28 * (std::abs(p.re[0].hi) + std::abs(p.re[4].hi));
    return p;
}

int counted(const std::vector<Zero>& zeros, std::vector<double> known) {
    return zeros_on_circle(polynomial(zeros), known.data(), int(known.size()));
}

void clusters_of_six_are_counted_with_twice_the_digits() {
    const std::vector<Zero> zeros = {{-1.5931, 0.0}, {-1.5721, 0.0}, {-1.5688, 0.0}, {-1.5645, 0.0}, {-1.5520, 0.0}, {-1.5231, 0.0},
                                     {0.3, 0.0},     {2.9, 0.0},     {-0.2, 4.0},    {1.0, 0.5},     {-2.0, 0.02},   {2.0, 1e-3}};
    std::vector<double> known;
    for (const Zero& each : zeros) {
        if (each.im == 0.0) known.push_back(each.re);
    }
    HOLDS(counted(zeros, known) == 8);
    // Doubles can't tell: they must not say that there are fewer.
    const OnCircle<Doubled> p = polynomial(zeros);
    OnCircle<double> rounded;
    for (int k = 0; k <= 8; ++k) rounded.re[k] = p.re[k].hi, rounded.im[k] = p.im[k].hi;
    rounded.error = 1e-15;
    const int many = zeros_on_circle(rounded, known.data(), int(known.size()));
    HOLDS(many == -1 || many >= 8);
}

void a_zero_that_is_not_known_is_counted() {
    const std::vector<Zero> zeros = {{0.1, 0.0}, {0.1003, 0.0}, {1.2, 0.0},  {-2.0, 0.0}, {0.5, 3.0},
                                     {0.8, 2.0}, {-1.0, 1.0},   {-1.5, 1.5}, {2.5, 0.7},  {3.0, 4.0}};
    HOLDS(counted(zeros, {0.1, 0.1003, 1.2, -2.0}) == 4);
    // Where one or both of a close pair are not known, the count may stay open, but is never smaller.
    for (const int many : {counted(zeros, {0.1, 1.2, -2.0}), counted(zeros, {1.2, -2.0})}) { HOLDS(many == -1 || many >= 4); }
}

// A pair that is not real but in the lens of its arc counts as two, wherever another pair is.
void pairs_beside_the_circle_count_with_their_arc() {
    for (const double off : {0.0, 1e-9, 1e-7}) {
        std::vector<Zero> zeros = {{0.7, 0.0}, {-2.2, 0.0}, {0.5, 3.0}, {0.8, 2.0}, {-1.0, 1.0}, {2.5, 0.7}, {3.0, 4.0}};
        if (off > 0.0) zeros.push_back({1.4, off});
        else zeros.push_back({1.4 - 1e-8, 0.0}), zeros.push_back({1.4 + 1e-8, 0.0});
        const std::vector<double> known = {0.7, -2.2, 1.4, 1.4};
        std::vector<Zero> all = zeros;
        all.push_back({-1.6, 2.0});
        HOLDS(counted(all, known) == 4);
        // Two more zeros elsewhere on the circle are two more.
        all = zeros;
        all.push_back({-1.6, 0.0}), all.push_back({-1.9, 0.0});
        HOLDS(counted(all, known) == 6);
        // Two more where the pair is: never four.
        all = zeros;
        all.push_back({1.4 + 2e-7, 0.0}), all.push_back({1.4 - 3e-7, 0.0});
        const int many = counted(all, known);
        HOLDS(many == -1 || many == 6);
    }
}

}  // namespace

void test_circle() {
    clusters_of_six_are_counted_with_twice_the_digits();
    a_zero_that_is_not_known_is_counted();
    pairs_beside_the_circle_count_with_their_arc();
}
