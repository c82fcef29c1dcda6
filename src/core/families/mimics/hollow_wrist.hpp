// All solutions of a 6R arm with a hollow wrist, such as ABB's IRB 5400: seven axes; axes 5 and 6 follow one joint, axis 6
// backwards.
//
// Axes 4 and 7 meet in a point W that joint 5 moves along both. For a value of joint 5 the target gives W, and W gives
// joints 1 to 3 (two fronts, two elbows). The angle between axes 4 and 7 then has to equal the one that joint 5 makes:
// one equation in one unknown for each branch. If all four axes meet in one point, W stands still and the equation is a
// trigonometric polynomial of degree two. In a mirrored wrist (axis 7 the mirror image of axis 4 in the plane between
// axes 5 and 6, a joint of constant velocity) the triangle of W and the two outer points is isosceles. Both kinds, and
// wrists near them, are solved alike: each branch is sampled as densely as joints 1 to 3 turn along it, and Newton's
// method on the arm as written starts from sign changes of the equation, from its extrema near zero, and from the ends
// of the branch, where it joins another.
#pragma once

#include "families/blocks.hpp"
#include "families/closed_forms/spherical_wrist.hpp"
#include "families/mimics/coupled_model.hpp"
#include "families/mimics/hollow_wrist_arm.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A margin that is negative at a sample by less than this may be positive between two samples.
inline constexpr double ALMOST = 1e-2;
// If the residual is below CORRECTED, the sample is moved in CORRECTION_ROUNDS rounds to where the arm as written has it.
inline constexpr double CORRECTED = 0.05;
inline constexpr int CORRECTION_ROUNDS = 4;
// Cosine of the greatest difference of joints 1 to 3 between neighbouring samples of a branch, 0.15 rad. Where W passes close to
// axis 1, joint 1 turns much faster than joint 5.
inline constexpr double COS_TURNING = 0.98877;
// Greatest number of samples that are put between two of the table's, and the number of times that their distance is
// halved at most.
inline constexpr int MOST_BETWEEN = 64, MOST_HALVINGS = 20;
struct HollowWrist {
    using Arm = HollowWristArm;
    static constexpr int branches = 32;

    // The equation at one value of joint 5 on one branch: its residual, the margins of shoulder and elbow, and joint 5,
    // and joints 1 to 3 with their offsets.
    struct Sample {
        double off, shoulder, elbow, joint_5;
        Turn<double> turn[3];
        double margin() const { return min(shoulder, elbow); }
        bool there() const { return margin() >= 0.0; }
        bool above() const { return off >= 0.0; }
    };

    // The greatest changes of the two margins between two samples.
    struct Moves {
        double shoulder, elbow;
        Moves half() const { return {0.5 * shoulder, 0.5 * elbow}; }
    };

    // The last two samples of a branch, and its first two, which follow on the last ones.
    struct Walk {
        Sample first[2], last[2];
        int many = 0;
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

    static STEP double step_of(const Arm& arm) { return arm.value[1] - arm.value[0]; }

    // The equation at joint 5 = t.
    static PART Sample at(Scan& search, double t) {
        const Arm& arm = search.arm;
        const double steps = (t - arm.value[0]) / step_of(arm), whole = __builtin_floor(steps), share = steps - whole;
        const int n = arm.samples, i = (int(whole) % n + n) % n, near[4] = {(i + n - 1) % n, i, (i + 1) % n, (i + 2) % n};
        // Lagrange's polynomial through four samples.
        const double a = share + 1.0, b = share, c = share - 1.0, d = share - 2.0;
        const double weight[4] = {b * c * d / -6.0, a * c * d / 2.0, a * b * d / -2.0, a * b * c / 6.0};
        const auto between = [&](const double* values) {
            double sum = 0.0;
            for (int l = 0; l < 4; ++l) sum += weight[l] * values[near[l]];
            return sum;
        };
        const double beyond = between(arm.along_4), back = between(arm.along_7);
        SphericalWristArm& p = search.position;
        const auto& ideal = p.ideal;
        const double* fixed = arm.position.centre;
        p.centre[1] = fixed[1] - ideal.sin_alpha[2] * beyond, p.centre[2] = fixed[2] + ideal.cos_alpha[2] * beyond;
        p.rho = sqrt(fixed[0] * fixed[0] + p.centre[1] * p.centre[1]);
        const Turn<double> phi = unit(fixed[0], p.centre[1]);
        p.cos_phi = phi.c, p.sin_phi = phi.s, p.height = ideal.d[0] + ideal.cos_alpha[1] * (p.centre[2] + ideal.d[1]);
        const Vec<double> W = search.flange + back * search.direction;
        Vec<double> goes = W;
        Sample s = {};
        for (int round = 0; round < CORRECTION_ROUNDS; ++round) {
            const Vec<double> seen = times(ideal.base_rotation, goes - vec<double>(ideal.base_origin));
            const Place<double> place = bend_elbow<double>(p, seen, face<double>(p, seen, search.front), {0.0, search.up, 0.0});
            const Rot<double> bent = wrist_rotation({search.level, search.level, search.level}, ideal, place);
            s = {bent.x.z - between(arm.cosine), place.margin1, place.margin2, t, {place.t1, place.t2, place.t3}};
            if (!s.there() || abs(s.off) > CORRECTED) break;
            const Aimed at = aim(search, s);
            s.off = at.off;
            const Vec<double> missed = W - (at.flange + back * at.direction);
            if (!(dot(missed, missed) > 1e-28)) break;
            goes = goes + missed;
        }
        return s;
    }

    // The arm as written at a sample's joints, with joint 4 such that axis 7 comes nearest to its wanted direction: joints
    // 1 to 4, the direction of axis 7, its point, and the residual.
    struct Aimed {
        double joints[4];
        Vec<double> direction, flange;
        double off;
    };
    static PART Aimed aim(const Scan& search, const Sample& s) {
        const auto& written = search.arm.written;
        const double* offset = search.position.ideal.offset;
        double x[6] = {0.0, 0.0, 0.0, 0.0, s.joint_5, 0.0};
        for (int j = 0; j < 3; ++j) x[j] = angle(s.turn[j]) - offset[j];
        const auto at = place(written, x);
        const Vec<double>&z4 = at.axis[3].R.z, &z7 = at.axis[6].R.z, &wanted = search.direction;
        const double sine = dot(z4, cross(z7, wanted)), cosine = dot(z7, wanted) - dot(z4, z7) * dot(z4, wanted);
        const Turn<double> turn = unit(cosine, sine);
        const Vec<double> arm = at.tip.p + at.tip.R * vec<double>(search.arm.flange) - at.axis[3].p;
        return {{x[0], x[1], x[2], angle(turn)},
                turned_about(z7, z4, turn),
                at.axis[3].p + turned_about(arm, z4, turn),
                dot(z4, wanted) - dot(z4, z7)};
    }

    // All values of joint 5 on one branch.
    static PART void scan(Scan& search) {
        const Arm& arm = search.arm;
        const int n = arm.samples;
        const auto& position = arm.position;
        const double step = step_of(arm), size = position.ideal.size;
        const double levers = 1.0 / abs(position.ideal.a[1]) + 1.0 / position.rho;
        const Vec<double> flange = times(position.ideal.base_rotation, search.flange - vec<double>(position.ideal.base_origin));
        double farthest = 0.0;  // of W from the flange
        for (int i = 0; i < n; ++i) farthest = max(farthest, abs(arm.along_7[i]));
        const double distance = sqrt(flange.x * flange.x + flange.y * flange.y) + farthest;  // of W from axis 1 at most
        Walk walk;
        Sample from = at(search, arm.value[0]);
        visit(search, walk, from);
        for (int i = 0; i < n; ++i) {
            const int k = (i + 1) % n;
            const Sample to = at(search, arm.value[0] + (i + 1) * step);
            // How far W moves along the two axes. The shoulder's margin is a squared distance, the elbow's a squared sine
            // by the law of cosines.
            const double moves = abs(arm.along_4[k] - arm.along_4[i]) + abs(arm.along_7[k] - arm.along_7[i]);
            int left = MOST_BETWEEN;
            go(search, walk, from, to, {2.0 * distance * moves / (size * size), 2.0 * moves * levers}, MOST_HALVINGS, left);
            from = to;
        }
        Sample again = walk.first[1];
        again.joint_5 += n * step;
        visit(search, walk, again);
    }

    // From one sample to the next, with as many between them as joints 1 to 3 turn, as well as the ends of the branch.
    static PART void go(Scan& search, Walk& walk, const Sample& from, const Sample& to, const Moves& moves, int halvings,
                        int& left) {
        const auto turns = [&] {
            double least = 1.0;
            for (int j = 0; j < 3; ++j) least = min(least, to.turn[j].c * from.turn[j].c + to.turn[j].s * from.turn[j].s);
            return least < COS_TURNING;
        };
        if (from.there() != to.there()) {
            const Sample end = end_of(search, from, to);
            if (from.there()) go(search, walk, from, end, {}, halvings, left);
            else visit(search, walk, end), go(search, walk, end, to, {}, halvings, left);
            if (from.there()) visit(search, walk, to);
            return;
        }
        const double shoulders = from.shoulder + to.shoulder, elbows = from.elbow + to.elbow;
        const bool crosses = from.there() ? shoulders < moves.shoulder || elbows < moves.elbow
                                          : shoulders > -moves.shoulder && elbows > -moves.elbow;
        if ((crosses || (from.there() && turns())) && halvings > 0 && left > 0) {
            const Sample middle = at(search, 0.5 * (from.joint_5 + to.joint_5));
            --left;
            go(search, walk, from, middle, moves.half(), halvings - 1, left);
            go(search, walk, middle, to, moves.half(), halvings - 1, left);
            return;
        }
        visit(search, walk, to);
    }

    // The end of the branch between two samples, one of which is on it.
    static PART Sample end_of(Scan& search, const Sample& from, const Sample& to) {
        Sample inside = from.there() ? from : to;
        double outside = from.there() ? to.joint_5 : from.joint_5;
        for (int round = 0; round < 30; ++round) {
            const Sample middle = at(search, 0.5 * (inside.joint_5 + outside));
            if (middle.there()) inside = middle;
            else outside = middle.joint_5;
        }
        return inside;
    }

    // The next sample along the branch.
    static PART void visit(Scan& search, Walk& walk, const Sample& next) {
        if (walk.many < 2) walk.first[walk.many] = next;
        else judge(search, walk.last[0], walk.last[1], next);
        walk.last[0] = walk.last[1], walk.last[1] = next;
        ++walk.many;
    }

    // Starts between the first two of three samples in a row, and around the second.
    static PART void judge(Scan& search, const Sample& before, const Sample& here, const Sample& next) {
        if (before.there() && here.there() && before.above() != here.above()) root(search, before, here);
        if (!here.there()) {
            const bool most = here.margin() >= before.margin() && here.margin() >= next.margin();
            if (most && here.margin() > -ALMOST) start(search, here, true);
        } else if (!before.there() || !next.there()) {
            branch_end(search, here, before.there() ? before : next);
        } else if (before.above() == here.above() && here.above() == next.above() && abs(here.off) <= abs(before.off) &&
                   abs(here.off) <= abs(next.off)) {
            near_double_root(search, before, here, next);
        }
    }

    // A change of sign between two samples (regula falsi, Illinois variant).
    static PART void root(Scan& search, const Sample& from, const Sample& to) {
        double a = from.joint_5, b = to.joint_5, off_a = from.off, off_b = to.off;
        Sample s = {};
        for (int round = 0; round < 4; ++round) {
            s = at(search, (a * off_b - b * off_a) / (off_b - off_a));
            if (s.above() != from.above()) b = s.joint_5, off_b = s.off, off_a *= round ? 0.5 : 1.0;
            else a = s.joint_5, off_a = s.off, off_b *= round ? 0.5 : 1.0;
            if (s.off == 0.0) break;
        }
        start(search, s, false);
    }

    // The equation has an extremum near a sample and no change of sign: starts from a parabola through three samples.
    static PART void near_double_root(Scan& search, const Sample& before, const Sample& here, const Sample& next) {
        const double back = here.joint_5 - before.joint_5, on = next.joint_5 - here.joint_5;
        const double slope_back = (here.off - before.off) / back, slope_on = (next.off - here.off) / on;
        const double bend = (slope_on - slope_back) / (back + on), slope = (slope_back * on + slope_on * back) / (back + on);
        if (abs(bend) < TINY) return;
        const double vertex = -0.5 * slope / bend, value = here.off + 0.5 * slope * vertex, width = max(back, on);
        // NEAR covers the table's interpolation and the imperfection of the arm.
        if (abs(value) > abs(bend) * width * width + NEAR) return;
        const double apart = sqrt(abs(value / bend));
        for (int side = -1; side <= 1; ++side) start(search, at(search, here.joint_5 + vertex + side * apart), true);
    }

    // The branch ends at a sample, where it joins another; `inside` is the next sample on it.
    static PART void branch_end(Scan& search, const Sample& end, const Sample& inside) {
        start(search, end, true);
        if (inside.there()) start(search, at(search, end.joint_5 + 0.1 * (inside.joint_5 - end.joint_5)), true);
    }

    // Finds the turns about axes 4 and 7 for a sample's joints, then runs Newton's method.
    static PART void start(Scan& search, const Sample& s, bool searched) {
        const auto& written = search.arm.written;
        const Aimed at = aim(search, s);
        double x[6] = {at.joints[0], at.joints[1], at.joints[2], 0.0, s.joint_5, 0.0};
        x[3] = wrap(wrap(at.joints[3])) * written.gain[3][3];
        const Rot<double> R = place(written, x).tip.R;
        const Rot<double>& G = search.goal.R;
        const Vec<double> turned = cross(R.x, G.x) + cross(R.y, G.y) + cross(R.z, G.z);
        const double trace = dot(R.x, G.x) + dot(R.y, G.y) + dot(R.z, G.z);
        x[5] = atan2(dot(search.direction, turned), trace - 1.0) * written.gain[6][5];
        polish_and_keep(written, search.goal, x, searched, search.columns);
    }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
