// Three joints, each turning or sliding, move a point X to a position p: all (q1, q2, q3) with p = g1 g2 g3 X.
//
// Joint 3 moves X to an affine function of phi = (cos q3, sin q3), or of phi = (q3, q3^2) if it slides. Two numbers of p do not
// depend on joint 1: height along its axis and distance from it, or for a slide the projection along it. They give two equations:
// - joint 2 turns: they are linear in the turned point w, across axis 2, with constant rows that are orthogonal:
//   m1.w = b1(phi), m2.w = b2(phi), and |w| = |y(phi)|. With both rows it is one equation of degree two in the harmonics of
//   q3 (four in q3); where a row vanishes (axes 1 and 2 parallel or meeting) its b alone gives q3.
// - joint 2 slides: q2 follows from one of them, and the other one gives q3.
// A polynomial in q3 becomes a trigonometric one by q3 = tan(t / 2), so one root finder serves all; a root at infinity
// lies at t = pi. Lengths are shares of the arm's size. Source: Pieper 1968, generalised to slides.
#pragma once

#include "families/few_joints/few_joints_arm.hpp"
#include "numbers/quartic.hpp"
#include "propose/answer.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// If the squared distance from a joint's axis is below this, the joint may be free or badly determined: it is tried at values
// around the circle.
inline constexpr double ALL_BUT_FREE = 1e-10;
// A slide further out than this share of the size is a root at infinity.
inline constexpr double FARTHEST_SLIDE = 1e6;

// The turn about unit h from a to b, of what lies across it; and the shorter squared length.
struct TurnAbout {
    double angle, square;
};
STEP TurnAbout turn_about(const Vec<double>& h, const Vec<double>& a, const Vec<double>& b) {
    const Vec<double> u = without(a, h), v = without(b, h);
    return {atan2(dot(h, cross(u, v)), dot(u, v)), min(dot(u, u), dot(v, v))};
}

// Bounds on errors, lengths as shares of the size: of a point's place, e P with e = PLACE_ERROR and P = 1 + |p|, for the structure
// of the arm and the rounding of the target; of the equations' coefficients, 909 e (1 + |p|^2)^2. Let d = p2 - p1 and z = g3 X - p2
// be at most 1 long, as parts of the arm are, and directions, d and z be off by e. Then of both rows' right sides
//   |b1| <= 2 P off by 6 e P,  |b2| <= 2 P^2 off by 6 e P^2,  |m1|^2 <= 1 by 4 e,  |m2|^2 <= 4 by 24 e,  (h2.z)^2 - z^2 by 6 e,
// and |m2|^2 b1^2 + |m1|^2 b2^2 + |m1|^2 |m2|^2 ((h2.z)^2 - z^2) is off by e (40 P^4 + 192 P^2 + 64). A coefficient of a
// trigonometric polynomial is at most twice its greatest value: e (80 P^4 + 384 P^2 + 128) <= 909 e (1 + |p|^2)^2. Where d or z
// exceeds 1, the feet of nearly parallel axes being far away, the bound grows with its fourth power.
inline constexpr double PLACE_ERROR = 1.1e-13;

// A candidate. free: bits 0 and 1 are set if the position leaves joints 1 and 2 nearly free. off: bounds on the distances of the
// solution from it, if Places::whole.
struct PlaceTried {
    double q[3];
    unsigned free;
    double off[3];
};
// Four roots twice where a row is weak, and their two signs. whole: each solution lies within the bounds of one of them.
struct Places {
    PlaceTried at[24];
    int count = 0;
    bool whole = true;
};

// constant + cosine cos q3 + sine sin q3, or of a slide constant + first q3 + second q3^2.
struct Form {
    double v[3];
    STEP double operator[](int k) const { return v[k]; }
};
STEP Form operator*(double f, const Form& a) { return {{f * a[0], f * a[1], f * a[2]}}; }
STEP Form operator+(const Form& a, const Form& b) { return {{a[0] + b[0], a[1] + b[1], a[2] + b[2]}}; }
STEP Form plus(Form a, double constant) { return {{a[0] + constant, a[1], a[2]}}; }

// Harmonics up to two, or powers up to four.
struct Equation {
    double f[5];
};

// Candidates for all solutions of a position. Those near an edge of reach are clamped, and those from weak equations approximate:
// the caller polishes and verifies them.
class PositionSolver {
public:
    // ref: the values of joints that the position leaves free.
    PositionSolver(const PositionStep& step, const Vec<double>& p, const double (&ref)[3])
        : step(step),
          p(p),
          h1(vec<double>(step.direction[0])),
          h2(vec<double>(step.direction[1])),
          p1(vec<double>(step.point[0])),
          p2(vec<double>(step.point[1])),
          third_slides(step.slides[2]) {
        for (int k = 0; k < 3; ++k) this->ref[k] = ref[k];
        place_error = PLACE_ERROR * (1.0 + sqrt(dot(p, p)));
        equation_error = 909.0 * PLACE_ERROR * (1.0 + dot(p, p)) * (1.0 + dot(p, p));
    }

    PART const Places& solve() {
        if (step.slides[1]) out.whole = false, step.slides[0] ? two_slides() : second_slides();
        else second_turns();
        return out;
    }

private:
    const PositionStep& step;
    const Vec<double> p, h1, h2, p1, p2;
    const bool third_slides;
    double ref[3], place_error, equation_error;
    Places out;

    // g3 X - origin as affine function of phi: coefficients of 1 and phi, and the form of its squared length.
    struct Third {
        Vec<double> Z[3];
        Form square;
        STEP Form along(const Vec<double>& h) const { return {{dot(h, Z[0]), dot(h, Z[1]), dot(h, Z[2])}}; }
    };
    STEP Third third(const Vec<double>& origin) const {
        const Vec<double> h3 = vec<double>(step.direction[2]), p3 = vec<double>(step.point[2]), X = vec<double>(step.X);
        Third t;
        if (third_slides) {
            t.Z[0] = X - origin, t.Z[1] = h3, t.Z[2] = {0.0, 0.0, 0.0};
            t.square = {{dot(t.Z[0], t.Z[0]), 2.0 * dot(t.Z[0], h3), 1.0}};
        } else {
            const Vec<double> across = without(X - p3, h3);
            t.Z[0] = X - across - origin, t.Z[1] = across, t.Z[2] = cross(h3, across);
            t.square = {{dot(t.Z[0], t.Z[0]) + dot(across, across), 2.0 * dot(t.Z[0], across), 2.0 * dot(t.Z[0], t.Z[2])}};
        }
        return t;
    }
    STEP Vec<double> point(const Third& t, double q3) const {
        if (third_slides) return t.Z[0] + q3 * t.Z[1];
        const Turn<double> turn = cos_sin(q3);
        return t.Z[0] + turn.c * t.Z[1] + turn.s * t.Z[2];
    }
    STEP double value(const Form& form, double q3) const {
        if (third_slides) return form[0] + q3 * (form[1] + q3 * form[2]);
        const Turn<double> turn = cos_sin(q3);
        return form[0] + turn.c * form[1] + turn.s * form[2];
    }

    // Add factor a b.
    STEP void add(Equation& e, const Form& a, const Form& b, double factor) const {
        if (third_slides) {
            for (int i = 0; i < 3; ++i) {
                for (int j = 0; j < 3; ++j) e.f[i + j] += factor * a[i] * b[j];
            }
        } else {
            e.f[0] += factor * (a[0] * b[0] + 0.5 * (a[1] * b[1] + a[2] * b[2]));
            e.f[1] += factor * (a[0] * b[1] + a[1] * b[0]);
            e.f[2] += factor * (a[0] * b[2] + a[2] * b[0]);
            e.f[3] += factor * 0.5 * (a[1] * b[1] - a[2] * b[2]);
            e.f[4] += factor * 0.5 * (a[1] * b[2] + a[2] * b[1]);
        }
    }
    static STEP Equation alone(const Form& a) { return {{a[0], a[1], a[2], 0.0, 0.0}}; }

    // off: as in PlaceTried.
    struct Roots {
        double at[4], off[4] = {};
        int count = 0;
    };
    // The roots of a square equation in a slide are within these bounds; returns whether that is certain.
    STEP bool bound_square(const double (&f)[5], Roots& r) const {
        if (f[2] == 0.0) {
            for (int i = 0; i < r.count; ++i) r.off[i] = equation_error * (1.0 + abs(r.at[i])) / abs(f[1]);
            return r.count == 1 && abs(f[1]) > NEAR;
        }
        const double square = f[1] * f[1] - 4.0 * f[0] * f[2],
                     error = 4.0 * equation_error * (abs(f[0]) + abs(f[1]) + abs(f[2]) + 1.0);
        for (int i = 0; i < r.count; ++i) {
            const double x = abs(r.at[i]);
            r.off[i] = 4.0 * equation_error * (1.0 + x + x * x) / sqrt(max(square, TINY));
        }
        return abs(f[2]) > NEAR && (square > 4.0 * error ? r.count == 2 : square < -error && r.count == 0);
    }
    // Real roots q3. If the equation vanishes, to `scale`, every q3 is a root and the reference is returned. linear: it has no
    // harmonic but the first.
    PART Roots roots(const Equation& e, double scale, bool linear = false) {
        const auto& f = e.f;
        const double largest = max(max(max(abs(f[0]), abs(f[1])), max(abs(f[2]), abs(f[3]))), abs(f[4]));
        Roots r;
        if (largest <= VANISHING * scale) {
            r.at[r.count++] = ref[2], out.whole = false;
            return r;
        }
        if (!third_slides) {
            // A root of the whole equation is one of the first harmonic and a constant, off by what is left out.
            const double beyond = max(abs(f[3]), abs(f[4])), left_out = 3.0 * beyond + 5.0 * equation_error;
            const Quartic circle = linear || beyond < VANISHING * largest
                                       ? first_harmonic_roots(f[0], f[1], f[2], linear ? equation_error : left_out)
                                       : trigonometric_roots({f[0], f[1], f[2], f[3], f[4]}, equation_error);
            out.whole = out.whole && circle.whole;
            for (int k = 0; k < circle.count; ++k) r.off[k] = 1.1 * circle.radius[k], r.at[r.count++] = angle(circle.root[k]);
            return r;
        }
        const bool squares = max(abs(f[3]), abs(f[4])) <= VANISHING * largest;
        const Quartic circle = squares ? trigonometric_roots({0.5 * (f[0] + f[2]), 0.5 * (f[0] - f[2]), 0.5 * f[1], 0.0, 0.0})
                                       : trigonometric_roots({3.0 * (f[0] + f[4]) + f[2], 4.0 * (f[0] - f[4]), 2.0 * (f[1] + f[3]),
                                                              f[0] - f[2] + f[4], f[1] - f[3]});
        for (int k = 0; k < circle.count; ++k) {
            const Turn<double>& t = circle.root[k];
            if (abs(t.s) <= FARTHEST_SLIDE * (1.0 + t.c)) r.at[r.count++] = t.s / (1.0 + t.c);
        }
        out.whole = out.whole && squares && bound_square(f, r);
        return r;
    }

    // Bounds on the errors of q3, of the point g3 X, of w and of q2.
    struct Off {
        double q3, point, w, q2;
    };
    // By how much a form, and the point g3 X, change at most for one unit of q3.
    STEP double slope(const Form& form, double q3) const {
        return third_slides ? abs(form[1]) + 2.0 * abs(form[2]) * (abs(q3) + 1.0) : abs(form[1]) + abs(form[2]);
    }
    STEP Off off_of(const Third& t, double q3) const {
        const double lever = sqrt(dot(t.Z[1], t.Z[1])) + sqrt(dot(t.Z[2], t.Z[2]));
        return {q3, lever * q3 + place_error, 0.0, 0.0};
    }

    // Add the solution with these q2 and q3; g23: g2 g3 X.
    STEP void finish(double q2, double q3, unsigned free, const Vec<double>& g23, const Off& off = {}) {
        if (out.count == int(sizeof(out.at) / sizeof(out.at[0]))) {
            out.whole = false;
            return;
        }
        double q1, lever = 1.0;
        if (step.slides[0]) {
            q1 = dot(h1, p - g23);
        } else {
            const TurnAbout t = turn_about(h1, g23 - p1, p - p1);
            q1 = t.square < VANISHING * VANISHING ? ref[0] : t.angle;
            lever = 0.6 * sqrt(t.square);
            if (t.square < ALL_BUT_FREE) free |= 1;
        }
        out.at[out.count++] = {{q1, q2, q3}, free, {(off.point + 2.0 * off.w + place_error) / max(lever, TINY), off.q2, off.q3}};
    }
    // Add the solution in which joint 2 turns z, the point g3 X seen from p2, so that its part across axis 2 points along w.
    STEP void turn_to(const Vec<double>& z, const Vec<double>& w, double q3, Off off) {
        const double along = dot(h2, z);
        const Vec<double> y = z - along * h2;
        off.q2 = (off.point + off.w) / max(0.6 * sqrt(dot(y, y)), TINY);
        const double square = dot(y, y), q2 = square < VANISHING * VANISHING ? ref[1] : atan2(dot(h2, cross(y, w)), dot(y, w));
        finish(q2, q3, square < ALL_BUT_FREE ? 2 : 0, p2 + along * h2 + turned_about(y, h2, cos_sin(q2)), off);
    }

    // Rows and right sides of the equations of a joint 2 that turns.
    struct Rows {
        Vec<double> M[2];
        Form b[2];
    };
    STEP Rows rows(const Third& t) const {
        Rows r;
        if (!step.slides[0]) {
            const Vec<double> d = p2 - p1, to = p - p1;
            r.M[0] = without(h1, h2), r.M[1] = 2.0 * d;
            r.b[0] = plus(-dot(h1, h2) * t.along(h2), dot(h1, to));
            r.b[1] = plus(-1.0 * t.square, dot(to, to) - dot(d, d));
            return r;
        }
        Vec<double> side = cross(h1, h2);
        if (sqrt(dot(side, side)) < VANISHING) side = cross(h1, p2 - p);
        if (sqrt(dot(side, side)) < VANISHING) side = cross(h1, Vec<double>{h1.y, h1.z, -h1.x});
        side = (1.0 / sqrt(dot(side, side))) * side;
        const Vec<double> up = cross(side, h1);
        r.M[0] = without(side, h2), r.M[1] = without(up, h2);
        r.b[0] = {{dot(side, p - p2), 0.0, 0.0}};
        r.b[1] = plus(-dot(up, h2) * t.along(h2), dot(up, p - p2));
        return r;
    }

    PART void second_turns() {
        const Third t = third(p2);
        const double d = sqrt(dot(p2 - p1, p2 - p1)), z = sqrt(dot(t.Z[0], t.Z[0])) + sqrt(dot(t.Z[1], t.Z[1]));
        const double longest = max(1.0, max(d, z));
        equation_error *= longest * longest * longest * longest;
        const Rows r = rows(t);
        const double m[2] = {dot(r.M[0], r.M[0]), dot(r.M[1], r.M[1])}, span = 1.0 + dot(p, p);
        if (min(m[0], m[1]) > VANISHING * VANISHING) {
            const double both = m[0] * m[1];
            Equation e = alone(-both * t.square);
            add(e, r.b[0], r.b[0], m[1]), add(e, r.b[1], r.b[1], m[0]), add(e, t.along(h2), t.along(h2), both);
            const Roots found = roots(e, both * span);
            for (int i = 0; i < found.count; ++i) {
                const double q3 = found.at[i];
                Off off = off_of(t, found.off[i]);
                for (int k = 0; k < 2; ++k) off.w += (slope(r.b[k], q3) * off.q3 + equation_error) / sqrt(m[k]);
                turn_to(point(t, q3), (value(r.b[0], q3) / m[0]) * r.M[0] + (value(r.b[1], q3) / m[1]) * r.M[1], q3, off);
            }
        }
        for (int k = 0; k < 2; ++k) {
            if (m[k] <= NEAR * NEAR && m[1 - k] > VANISHING * VANISHING) by_other_row(t, r, k, m[1 - k], span);
        }
        // Either both rows or one.
        const double least = min(m[0], m[1]), most = max(m[0], m[1]);
        out.whole = out.whole && most > NEAR * NEAR && (least > NEAR * NEAR || least <= VANISHING * VANISHING);
    }
    // Row k is weak: its right side alone gives q3, and the other row gives the component of w along it.
    STEP void by_other_row(const Third& t, const Rows& r, int k, double m, double span) {
        const Vec<double>& row = r.M[1 - k];
        const Vec<double> side = (1.0 / sqrt(m)) * cross(h2, row);
        const Roots found = roots(alone(r.b[k]), span, true);
        for (int i = 0; i < found.count; ++i) {
            const Vec<double> z = point(t, found.at[i]), y = without(z, h2);
            const double foot = value(r.b[1 - k], found.at[i]) / m, rest = dot(y, y) - foot * foot * m;
            Off off = off_of(t, found.off[i]);
            const double of_foot = slope(r.b[1 - k], found.at[i]) * off.q3 + equation_error;
            const double of_rest = 4.0 * (sqrt(dot(y, y)) * off.point + abs(foot) * of_foot);
            if (rest < -NEAR * span) continue;
            const double height = sqrt(max(rest, 0.0));
            // Where `rest` may be zero the root is at most that of twice its error.
            off.w = of_foot / sqrt(m) + (rest > of_rest ? of_rest / height : 2.5 * sqrt(of_rest));
            turn_to(z, foot * row + height * side, found.at[i], off);
            if (height > 0.0) turn_to(z, foot * row - height * side, found.at[i], off);
        }
    }

    // Joints 1 and 2 slide.
    STEP void two_slides() {
        const Third t = third(p);
        const Vec<double> side = cross(h1, h2), up = (1.0 / dot(side, side)) * cross(side, h1);
        const Roots found = roots(alone(t.along(side)), 1.0 + dot(p, p));
        for (int i = 0; i < found.count; ++i) {
            const Vec<double> z = point(t, found.at[i]);
            const double q2 = -dot(up, z);
            finish(q2, found.at[i], 0, p + z + q2 * h2);
        }
    }

    // Joint 1 turns, joint 2 slides.
    PART void second_slides() {
        const Third t = third(p1);
        const Vec<double> to = p - p1;
        const double slope = dot(h1, h2), square = dot(to, to), span = 1.0 + dot(p, p);
        const Form height = plus(-1.0 * t.along(h1), dot(h1, to));
        if (abs(slope) > VANISHING) {
            Equation e = alone(plus(slope * slope * t.square, -slope * slope * square));
            add(e, height, t.along(h2), 2.0 * slope), add(e, height, height, 1.0);
            const Roots found = roots(e, slope * slope * span);
            for (int i = 0; i < found.count; ++i) {
                const double q2 = value(height, found.at[i]) / slope;
                finish(q2, found.at[i], 0, p1 + point(t, found.at[i]) + q2 * h2);
            }
        }
        if (abs(slope) >= NEAR) return;
        const Roots found = roots(alone(height), span);
        for (int i = 0; i < found.count; ++i) {
            const Vec<double> z = point(t, found.at[i]);
            const double half = dot(h2, z), rest = half * half - dot(z, z) + square;
            if (rest < -NEAR * span) continue;
            const double root = sqrt(max(rest, 0.0));
            finish(root - half, found.at[i], 0, p1 + z + (root - half) * h2);
            if (rest > 0.0) finish(-root - half, found.at[i], 0, p1 + z - (root + half) * h2);
        }
    }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
