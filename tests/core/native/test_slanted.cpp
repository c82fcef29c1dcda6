// A slanted number of a result holds its value at t = 0, its change from there and its value at t, for all that the slanted numbers
// of its arguments hold. Oracle: long double.
#include "arithmetic/slanted.hpp"

#include <random>

#include "facts.hpp"
#include "kinematics/subproblems.hpp"

using namespace urdf_ik::URDF_IK_LEVEL;

namespace {

using Exact = long double;
using Number = Slanted<double>;
std::mt19937_64 generator(11);
double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(generator); }
double size(double low, double high) { return std::pow(10.0, uniform(low, high)); }
double sign() { return uniform(0.0, 1.0) < 0.5 ? -1.0 : 1.0; }

// Differences of the oracle's numbers err by 1e-18.
bool holds(const Ball<double>& ball, Exact value) {
    return !(fabsl(value - Exact(ball.mid)) > Exact(ball.rad) * Exact(INFLATED) + 1e-17L);
}
Ball<double> around(Exact value) {
    const double radius = uniform(0.0, 1.0) < 0.2 ? 0.0 : size(-17.0, -1.0),
                 mid = double(value + Exact(radius) * Exact(uniform(-1.0, 1.0)));
    return {mid, std::fmax(radius, double(fabsl(value - Exact(mid))))};
}

bool moves(const Ball<double>& slope, Exact change, Exact t) { return holds({0.0, slope.rad}, change - t * Exact(slope.mid)); }

// A value at t = 0 and at t, and a slanted number that holds both.
struct Held {
    Exact start, end;
    Number number;
};
Held held(Exact start, Exact end, Exact t) {
    const Exact slope = (end - start) / t;
    return {start, end, {around(start), around(slope), around(end)}};
}
Held held(Exact t) {
    const Exact start = sign() * size(-7.0, 0.5), slope = sign() * size(-8.0, 0.0);
    return held(start, start + t * slope, t);
}
bool holds(const Number& a, Exact start, Exact end, Exact t) {
    return holds(a.at, start) && holds(a.all, end) && moves(a.slope, end - start, t);
}
Exact part() { return sign() * uniform(0.05, 1.0); }

void sums_products_and_quotients() {
    for (int k = 0; k < 20000; ++k) {
        const Exact t = part();
        const Held a = held(t), b = held(t);
        const double c = uniform(-3.0, 3.0);
        HOLDS(holds(a.number + b.number, a.start + b.start, a.end + b.end, t));
        HOLDS(holds(a.number - b.number, a.start - b.start, a.end - b.end, t));
        HOLDS(holds(a.number * b.number, a.start * b.start, a.end * b.end, t));
        HOLDS(holds(c * a.number - c, c * a.start - c, c * a.end - c, t) && holds(c - a.number, c - a.start, c - a.end, t));
        HOLDS(holds(max(a.number, b.number), fmaxl(a.start, b.start), fmaxl(a.end, b.end), t));
        HOLDS(holds(min(a.number, c), fminl(a.start, c), fminl(a.end, c), t));
        HOLDS(holds(abs(a.number), fabsl(a.start), fabsl(a.end), t));
        HOLDS(holds(a.number / b.number, a.start / b.start, a.end / b.end, t));
    }
}

void roots() {
    int narrow = 0;
    for (int k = 0; k < 20000; ++k) {
        const Exact t = part();
        const Held a = held(t);
        HOLDS(holds(root(a.number), sqrtl(fmaxl(a.start, 0.0L)), sqrtl(fmaxl(a.end, 0.0L)), t));
        narrow += root(a.number).slope.rad < 1.0;
    }
    HOLDS(narrow > 1000);
}

void directions() {
    int narrow = 0;
    for (int k = 0; k < 20000; ++k) {
        const Exact t = part();
        const Held c = held(t), s = held(t);
        const Turn<Number> arc = unit(c.number, s.number);
        const Exact start = hypotl(c.start, s.start), end = hypotl(c.end, s.end);
        const bool whole = arc.c.at.mid == 0.0 && arc.s.at.mid == 0.0;
        const auto good = [&](const Number& a, Exact from, Exact to) {
            return (whole || holds(a.at, from)) && (holds(a.all, to) || a.all.rad == 1.0) &&
                   (whole || moves(a.slope, to - from, t));
        };
        HOLDS(good(arc.c, c.start / start, c.end / end) && good(arc.s, s.start / start, s.end / end));
        narrow += arc.c.slope.rad < 0.1;
        // The ranges of both are one disc, also where an arc is chosen among two.
        const Turn<Number> chosen = {select(true, arc.c, c.number), select(true, arc.s, s.number)};
        HOLDS(chosen.c.all.rad == chosen.s.all.rad && chosen.c.all.mid == arc.c.all.mid && chosen.s.all.mid == arc.s.all.mid);
    }
    HOLDS(narrow > 1000);
}

// An elbow and a swing whose target moves with t, made from the turns that solve them.
void subproblems() {
    int narrow = 0;
    for (int k = 0; k < 20000; ++k) {
        const Exact t = part();
        const double a = uniform(0.2, 0.6), b = uniform(0.2, 0.6), side = sign(), speed = size(-6.0, -0.7);
        const Exact first = uniform(-PI, PI), bend = size(-3.0, 0.4), first_end = first + t * uniform(-1.0, 1.0) * speed,
                    bend_end = fabsl(bend + t * uniform(-1.0, 1.0) * speed);
        const auto x = [&](Exact q, Exact g) { return a * cosl(q) + b * cosl(q + side * g); };
        const auto y = [&](Exact q, Exact g) { return a * sinl(q) + b * sinl(q + side * g); };
        const auto exact = [&](Exact from, Exact to) {
            const Exact slope = (to - from) / t;
            return Number({double(from), 2e-16}, {double(slope), 1e-15 + 1e-16 * double(fabsl(slope))}, {double(to), 2e-16});
        };
        const Elbow<Number> e = elbow(exact(x(first, bend), x(first_end, bend_end)), exact(y(first, bend), y(first_end, bend_end)),
                                      a, b, side, Number(1.0));
        HOLDS(holds(e.second.c, cosl(first), cosl(first_end), t) || e.second.c.at.mid == 0.0 || e.second.c.all.rad == 1.0);
        HOLDS(holds(e.bend.c, cosl(bend), cosl(bend_end), t) && holds(e.bend.s, sinl(bend), sinl(bend_end), t));
        narrow += e.bend.s.slope.rad < 0.1;

        const double X = size(-3.0, 0.0), offset = uniform(-1.0, 1.0);
        const auto px = [&](Exact q) { return X * cosl(q) - offset * sinl(q); };
        const auto py = [&](Exact q) { return X * sinl(q) + offset * cosl(q); };
        const Swing<Number> s =
            swing_to_offset<Number>(exact(px(first), px(first_end)), exact(py(first), py(first_end)), Number(offset), Number(1.0));
        HOLDS(holds(s.turn.s, sinl(first), sinl(first_end), t) || s.turn.s.at.mid == 0.0 || s.turn.s.all.rad == 1.0);
        HOLDS(holds(s.X, X, X, t));
    }
    HOLDS(narrow > 1000);
}

}  // namespace

void test_slanted() {
    sums_products_and_quotients();
    roots();
    directions();
    subproblems();
}
