// Each subproblem's answer satisfies its equation.
#include "arm/subproblems.hpp"

#include "facts.hpp"

using namespace urdf_ik::URDF_IK_LEVEL;

static Turn<double> turn_of_angle(double a) { return {std::cos(a), std::sin(a)}; }
static Vec<double> about_z(const Turn<double>& t, const Vec<double>& v) {
    return {t.c * v.x - t.s * v.y, t.s * v.x + t.c * v.y, v.z};
}
static Vec<double> about_x(double c, double s, const Vec<double>& v) { return {v.x, c * v.y - s * v.z, s * v.y + c * v.z}; }

// Rz(first) Rx(alpha) Rz(bend) Rx(beta) Rz(last) of a vector.
static Vec<double> wrist(const Turn<double>& first, const Turn<double>& bend, const Turn<double>& last, const Twists& t,
                         const Vec<double>& v) {
    return about_z(first, about_x(t.ca, t.sa, about_z(bend, about_x(t.cb, t.sb, about_z(last, v)))));
}

static void a_swing_reaches_the_offset() {
    for (const double sign : {1.0, -1.0}) {
        const Swing<double> s = swing_to_offset(0.6, 0.5, 0.3, sign);
        // (X, k) turned by the answer is (x, y).
        HOLDS(near(s.turn.c * s.X - s.turn.s * 0.3, 0.6, 1e-15) && near(s.turn.s * s.X + s.turn.c * 0.3, 0.5, 1e-15));
        HOLDS(near(s.margin, 0.36 + 0.25 - 0.09, 1e-15));
    }
    HOLDS(swing_to_offset(0.1, 0.1, 0.3, 1.0).margin < 0.0);  // nearer to the axis than the offset
}

static void an_elbow_obeys_the_law_of_cosines() {
    constexpr double a = 0.4, b = 0.3;
    for (int k = 1; k < 100; ++k) {
        const double far = 0.1 + 0.006 * k, ux = far * std::cos(0.3 * k), uy = far * std::sin(0.3 * k);
        for (const double side : {1.0, -1.0}) {
            for (const double sign : {1.0, -1.0}) {
                const Elbow<double> e = elbow(ux, uy, a, b, side, sign);
                // a e(q2) + b e(q2 + side gamma) = u
                const double c = e.second.c * e.bend.c - side * e.second.s * e.bend.s;
                const double s = e.second.s * e.bend.c + side * e.second.c * e.bend.s;
                HOLDS(near(a * e.second.c + b * c, ux, 1e-14) && near(a * e.second.s + b * s, uy, 1e-14));
                HOLDS(e.margin > 0.0 && e.bend.s * sign >= 0.0);
            }
        }
    }
    HOLDS(elbow(0.8, 0.0, a, b, 1.0, 1.0).margin < 0.0);   // beyond the stretched arm
    HOLDS(elbow(0.05, 0.0, a, b, 1.0, 1.0).margin < 0.0);  // within the folded one
    HOLDS(near(elbow(0.7, 0.0, a, b, 1.0, 1.0).margin, 0.0, 1e-15));
}

static void a_wrist_turns_back_to_where_it_was() {
    const double alpha = 1.1, beta = -0.8;
    const Twists t = {std::cos(alpha), std::sin(alpha), std::cos(beta), std::sin(beta)};
    for (int k = 0; k < 50; ++k) {
        const Turn<double> first = turn_of_angle(0.37 * k), bend = turn_of_angle(0.2 + 0.05 * k),
                           last = turn_of_angle(1.3 - 0.21 * k);
        Rot<double> M;
        M.x = wrist(first, bend, last, t, {1.0, 0.0, 0.0}), M.y = wrist(first, bend, last, t, {0.0, 1.0, 0.0});
        M.z = wrist(first, bend, last, t, {0.0, 0.0, 1.0});
        bool planted = false;
        for (const double sign : {1.0, -1.0}) {
            const Bend<double> b = wrist_bend(M.z, t, sign);
            const WristTurns<double> w = wrist_turns(M, b.turn, t);
            HOLDS(b.margin > 0.0 && w.error < 1e-24);
            planted |= near(w.first.c, first.c, 1e-12) && near(w.first.s, first.s, 1e-12) && near(b.turn.c, bend.c, 1e-12) &&
                       near(b.turn.s, bend.s, 1e-12) && near(w.last.c, last.c, 1e-12) && near(w.last.s, last.s, 1e-12);
        }
        HOLDS(planted);
    }
}

void test_subproblems() {
    a_swing_reaches_the_offset();
    an_elbow_obeys_the_law_of_cosines();
    a_wrist_turns_back_to_where_it_was();
}
