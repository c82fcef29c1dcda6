// A ball of a result holds the exact result of every number that the balls of its arguments hold. Oracle: long double.
#include "numbers/ball.hpp"

#include <random>

#include "arm/subproblems.hpp"
#include "facts.hpp"

using namespace urdf_ik;
using namespace urdf_ik::URDF_IK_LEVEL;

namespace {

using Exact = long double;
std::mt19937_64 generator(7);
double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(generator); }

// A number and a ball that holds it: small and large radii, and none.
struct Held {
    Exact value;
    Ball<double> ball;
};
Held held(double mid) {
    const double radius = uniform(0.0, 1.0) < 0.2 ? 0.0 : std::pow(10.0, uniform(-17.0, -0.3));
    return {Exact(mid) + Exact(radius) * Exact(uniform(-1.0, 1.0)), {mid, radius}};
}
bool holds(const Ball<double>& ball, Exact value) { return fabsl(value - Exact(ball.mid)) <= Exact(ball.rad) * Exact(INFLATED); }

void sums_products_and_quotients() {
    for (int k = 0; k < 20000; ++k) {
        const Held a = held(uniform(-3.0, 3.0)), b = held(uniform(-3.0, 3.0));
        const double c = uniform(-3.0, 3.0);
        HOLDS(holds(a.ball + b.ball, a.value + b.value) && holds(a.ball - b.ball, a.value - b.value));
        HOLDS(holds(a.ball * b.ball, a.value * b.value) && holds(-a.ball, -a.value));
        HOLDS(holds(a.ball + c, a.value + c) && holds(a.ball - c, a.value - c) && holds(c - a.ball, c - a.value));
        HOLDS(holds(a.ball * c, a.value * c) && holds(c * a.ball, a.value * c));
        HOLDS(holds(max(a.ball, b.ball), fmaxl(a.value, b.value)) && holds(min(a.ball, c), fminl(a.value, c)));
        HOLDS(holds(abs(a.ball), fabsl(a.value)));
        // What is divided by a ball that holds zero has no bound: the radius is infinite, or NaN.
        const Ball<double> quotient = a.ball / b.ball;
        HOLDS(b.ball.rad < std::fabs(b.ball.mid) ? holds(quotient, a.value / b.value) : !(quotient.rad < 1e300));
    }
}

// The root of a margin is that of the part of the ball that is not negative.
void roots() {
    for (int k = 0; k < 20000; ++k) {
        const Held a = held(std::pow(10.0, uniform(-16.0, 0.5)) * (uniform(0.0, 1.0) < 0.3 ? -1.0 : 1.0));
        if (a.value >= 0.0L) HOLDS(holds(margin_root(a.ball), sqrtl(a.value)));
    }
}

// The direction of a vector of a disc lies within the chord of the arc's centre, or the arc is the whole circle.
bool turns(const Turn<Ball<double>>& arc, Exact c, Exact s) {
    const Exact size = hypotl(c, s), x = c / size - Exact(arc.c.mid), y = s / size - Exact(arc.s.mid);
    const bool whole = arc.c.mid == 0.0 && arc.s.mid == 0.0 && arc.c.rad == 1.0;
    return whole || hypotl(x, y) <= Exact(arc.c.rad) * Exact(INFLATED);
}
void directions() {
    int whole = 0;
    for (int k = 0; k < 20000; ++k) {
        const double length = std::pow(10.0, uniform(-9.0, 0.3)), angle = uniform(-PI, PI);
        const Held c = held(length * std::cos(angle)), s = held(length * std::sin(angle));
        const Turn<Ball<double>> arc = unit(c.ball, s.ball);
        HOLDS(turns(arc, c.value, s.value));
        whole += arc.c.mid == 0.0;
    }
    HOLDS(whole > 1000 && whole < 19000);
}

// The subproblems on balls: an elbow and a swing of a target that the ball holds, made from the turns that solve it.
void subproblems() {
    for (int k = 0; k < 20000; ++k) {
        const double a = uniform(0.2, 0.6), b = uniform(0.2, 0.6), side = uniform(0.0, 1.0) < 0.5 ? 1.0 : -1.0;
        // Straight, folded and generic elbows.
        const double first = uniform(-PI, PI), near = std::pow(10.0, uniform(-9.0, 0.49)),
                     bend = uniform(0.0, 1.0) < 0.3 ? PI - near : near;
        const Exact x = a * cosl(first) + b * cosl(Exact(first) + side * Exact(bend)),
                    y = a * sinl(first) + b * sinl(Exact(first) + side * Exact(bend));
        const double radius = 1e-16 + std::pow(10.0, uniform(-16.0, -2.0));
        const Ball<double> ux = {double(x), radius}, uy = {double(y), radius}, sign = std::sin(bend) < 0.0 ? -1.0 : 1.0;
        const Elbow<Ball<double>> e = elbow(ux, uy, a, b, side, sign);
        HOLDS(turns(e.second, cosl(first), sinl(first)));
        HOLDS(holds(e.bend.c, cosl(bend)) && holds(e.bend.s, sinl(bend)));
        HOLDS(holds(e.margin, sinl(bend) * sinl(bend)));

        const double X = near * (uniform(0.0, 1.0) < 0.5 ? -1.0 : 1.0), offset = uniform(-1.0, 1.0);
        const Exact px = X * cosl(first) - offset * sinl(first), py = X * sinl(first) + offset * cosl(first);
        const Ball<double> k_ball = {offset, radius}, side_of_X = X < 0.0 ? -1.0 : 1.0;
        const Swing<Ball<double>> s = swing_to_offset<Ball<double>>({double(px), radius}, {double(py), radius}, k_ball, side_of_X);
        HOLDS(turns(s.turn, cosl(first), sinl(first)) && holds(s.margin, Exact(X) * X));
    }
}

}  // namespace

void test_balls() {
    sums_products_and_quotients();
    roots();
    directions();
    subproblems();
}
