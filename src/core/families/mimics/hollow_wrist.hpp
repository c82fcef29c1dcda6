// All solutions of a 6R arm with a hollow wrist, such as ABB's IRB 5400: seven axes; axes 5 and 6 follow one joint, axis 6
// backwards.
//
// Axes 4 and 7 meet in a point W that joint 5 moves along both. For a value of joint 5 the target gives W, and W gives
// joints 1 to 3 (two fronts, two elbows). The angle between axes 4 and 7 then has to equal the one that joint 5 makes:
// one equation in one unknown for each branch. If all four axes meet in one point, W stands still and the equation is a
// trigonometric polynomial of degree two. In a mirrored wrist (axis 7 the mirror image of axis 4 in the plane between
// axes 5 and 6, a joint of constant velocity) the triangle of W and the two outer points is isosceles. Both kinds, and
// wrists near them, are solved alike: sign changes of the equation over samples of joint 5, then Newton's method on the
// arm as written. If the equation comes near zero between samples, a pair of solutions closer together than the samples
// is searched there.
#pragma once

#include "answers/blocks.hpp"
#include "families/closed_forms/spherical_wrist.hpp"
#include "families/mimics/coupled_model.hpp"
#include "families/mimics/hollow_wrist_arm.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The turn about axis 4 is determined by the sine of the angle from axis 4 to axis 7, times the sine of the angle from
// axis 4 to the wanted direction of axis 7. If the product is below ALIGNED, TURNS_TRIED turns around the circle are
// tried.
inline constexpr double ALIGNED = 1e-2;
inline constexpr int TURNS_TRIED = 8;
// A margin that is negative at a sample by less than this may be positive between two samples.
inline constexpr double ALMOST = 1e-2;

struct HollowWrist {
    using Arm = HollowWristArm;
    static constexpr int branches = 32;

    // The equation at one value of joint 5 on one branch: its residual, the margin of the branch, and joints 5 and 1 to
    // 3.
    struct Sample {
        double off, margin, joint_5, q[3];
        bool there() const { return margin >= 0.0; }
    };

    struct Scan {
        const Arm& arm;
        const Goal<double>& goal;
        const Columns<6>& columns;
        SphericalWristArm position;  // of the sample at hand
        Vec<double> flange, direction, level;  // of axis 7: a point and the direction, in the base and (level) in frame 1
        double front, up;
    };

    static PART void solve(const Arm& arm, const Goal<double>& goal, const Reference<6>&, const Columns<6>& columns) {
        const auto& ideal = arm.position.ideal;
        const Vec<double> direction = goal.R * vec<double>(arm.direction);
        Scan search = {arm,
                       goal,
                       columns,
                       arm.position,
                       goal.p + goal.R * vec<double>(arm.flange),
                       direction,
                       times(ideal.base_rotation, direction),
                       0.0,
                       0.0};
        for (int pair = 0; pair < 4; ++pair) {
            search.front = ideal.signs[0][2 * pair], search.up = ideal.signs[1][2 * pair];
            scan(search);
        }
        finish(arm.written, columns);
        // A scan cannot prove that its result is complete.
        set_status(columns.flags[0], Status::incomplete);
    }

    // The equation at the share t of the way from sample i to the next.
    static PART Sample at(Scan& search, int i, double t) {
        const Arm& arm = search.arm;
        const int k = i + 1 < arm.samples ? i + 1 : arm.round ? 0 : i;
        const auto between = [&](const double* values) { return values[i] + t * (values[k] - values[i]); };
        const double step = arm.value[1] - arm.value[0], beyond = between(arm.along_4), back = between(arm.along_7);
        SphericalWristArm& p = search.position;
        const auto& ideal = p.ideal;
        const double* fixed = arm.position.centre;
        p.centre[1] = fixed[1] - ideal.sin_alpha[2] * beyond, p.centre[2] = fixed[2] + ideal.cos_alpha[2] * beyond;
        p.rho = sqrt(fixed[0] * fixed[0] + p.centre[1] * p.centre[1]);
        const Turn<double> phi = unit(fixed[0], p.centre[1]);
        p.cos_phi = phi.c, p.sin_phi = phi.s, p.height = ideal.d[0] + ideal.cos_alpha[1] * (p.centre[2] + ideal.d[1]);
        const Vec<double> W = search.flange + back * search.direction - vec<double>(ideal.base_origin);
        const Vec<double> seen = times(ideal.base_rotation, W);
        const Place<double> place = bend_elbow<double>(p, seen, face<double>(p, seen, search.front), search.up, {});
        const Rot<double> bent = wrist_rotation({search.level, search.level, search.level}, ideal, place);
        const double* offset = ideal.offset;
        return {bent.x.z - between(arm.cosine),
                min(place.margin1, place.margin2),
                arm.value[i] + t * step,
                {wrap(angle(place.t1) - offset[0]), wrap(angle(place.t2) - offset[1]), wrap(angle(place.t3) - offset[2])}};
    }

    // All values of joint 5 on one branch.
    static PART void scan(Scan& search) {
        const int n = search.arm.samples, steps = search.arm.round ? n : n - 1;
        double off[MOST_SAMPLES], margin[MOST_SAMPLES];
        for (int i = 0; i < n; ++i) {
            const Sample s = at(search, i, 0.0);
            off[i] = s.off, margin[i] = s.margin;
        }
        for (int i = 0; i < steps; ++i) {
            const int before = i > 0 ? i - 1 : search.arm.round ? n - 1 : 0, k = (i + 1) % n;
            const bool here = margin[i] >= 0.0, next = margin[k] >= 0.0;
            if (here != next) {
                branch_end(search, i, here, here ? off[i] : off[k]);
            } else if (!here) {
                const bool most = margin[i] >= margin[before] && margin[i] >= margin[k];
                if (most && margin[i] > -ALMOST) start(search, at(search, i, 0.0), true);
            } else if ((off[i] < 0.0) != (off[k] < 0.0)) {
                root(search, i, 0.0, off[i], 1.0, off[k]);
            } else if (margin[before] >= 0.0 && abs(off[i]) <= abs(off[before]) && abs(off[i]) <= abs(off[k])) {
                near_double_root(search, i, off[before], off[i], off[k]);
            }
        }
    }

    // A change of sign between shares a and b of the way from sample i (regula falsi, Illinois variant).
    static PART void root(Scan& search, int i, double a, double off_a, double b, double off_b) {
        Sample s = {};
        for (int round = 0; round < 4; ++round) {
            const double t = (a * off_b - b * off_a) / (off_b - off_a);
            s = at(search, i, t);
            if ((s.off < 0.0) != (off_a < 0.0)) b = t, off_b = s.off, off_a *= round ? 0.5 : 1.0;
            else a = t, off_a = s.off, off_b *= round ? 0.5 : 1.0;
            if (s.off == 0.0) break;
        }
        start(search, s, false);
    }

    // The equation has an extremum near sample i and no change of sign: starts from a parabola through three samples.
    static PART void near_double_root(Scan& search, int i, double before, double off, double after) {
        const double bend = before - 2.0 * off + after;
        if (abs(bend) < TINY) return;
        const double vertex = 0.5 * (before - after) / bend, value = off - 0.25 * (before - after) * vertex;
        if (abs(value) > abs(bend)) return;
        const double apart = sqrt(2.0 * abs(value / bend));
        for (int side = -1; side <= 1; ++side) start(search, at(search, i, vertex + side * apart), true);
    }

    // A branch ends between sample i and the next, where it joins another.
    static PART void branch_end(Scan& search, int i, bool here, double off) {
        double inside = here ? 0.0 : 1.0, outside = 1.0 - inside;
        const double from = inside;
        for (int round = 0; round < 30; ++round) {
            const double t = 0.5 * (inside + outside);
            (at(search, i, t).there() ? inside : outside) = t;
        }
        const Sample end = at(search, i, inside);
        if ((end.off < 0.0) != (off < 0.0)) root(search, i, from, off, inside, end.off);
        start(search, end, true);
        start(search, at(search, i, inside + 0.1 * (from - inside)), true);
    }

    // Finds the turns about axes 4 and 7 for a sample's joints, then runs Newton's method.
    static PART void start(Scan& search, const Sample& s, bool searched) {
        const auto& written = search.arm.written;
        double x[6] = {s.q[0], s.q[1], s.q[2], 0.0, s.joint_5, 0.0};
        const auto at = place(written, x);
        const Vec<double>&z4 = at.axis[3].R.z, &z7 = at.axis[6].R.z, &wanted = search.direction;
        const double sine = dot(z4, cross(z7, wanted)), cosine = dot(z7, wanted) - dot(z4, z7) * dot(z4, wanted);
        const bool aligned = sine * sine + cosine * cosine < ALIGNED * ALIGNED;
        const double first = atan2(sine, cosine);
        for (int k = 0; k < (aligned ? TURNS_TRIED : 1); ++k) {
            x[3] = wrap(wrap(first + k * (2.0 * PI / TURNS_TRIED))) * written.gain[3][3], x[5] = 0.0;
            const Rot<double> R = place(written, x).tip.R;
            const Rot<double>& G = search.goal.R;
            const Vec<double> turned = cross(R.x, G.x) + cross(R.y, G.y) + cross(R.z, G.z);
            const double trace = dot(R.x, G.x) + dot(R.y, G.y) + dot(R.z, G.z);
            x[5] = atan2(dot(wanted, turned), trace - 1.0) * written.gain[6][5];
            double from[6];
            for (int j = 0; j < 6; ++j) from[j] = x[j];
            polish_and_keep(written, search.goal, from, searched || aligned, search.columns);
        }
    }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
