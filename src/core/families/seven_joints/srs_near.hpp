// All solutions, at a swivel angle, of an arm whose axes 1 to 3 and 5 to 7 nearly meet. Newton's method at this swivel
// angle leads from the eight solutions of the nearest S-R-S arm to those of the arm as written. Near a singularity of
// the ideal arm the two arms differ in their number of solutions, and further starts around the singularity are tried.
#pragma once

#include "families/seven_joints/srs_boxes.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A bend is the root x of a margin: x^2 = m on the ideal arm, x^2 = m + e on the arm as written. Newton's method from
// sqrt(m) finds this root and no other if |e| < m (Kantorovich: |x^2 - m - e| times the second derivative, 2, over the
// square of the first, 4 m, is below one half). An error of the ideal arm changes the cosine of a triple's bend by the
// error over the product of the twists' sines, and that of a stretched elbow by size^2 / (2 upper fore) times the
// error. The margin changes by twice as much: 16 times the error if each link is a quarter of the size. The other
// triple adds its own. So a start is safe if m exceeds UNSURE times the error. Otherwise further starts are tried, at a
// margin of a tenth of UNSURE times the error above the ideal one: from a larger x, Newton's method descends to the root,
// however small it is.
// Measured on the four nearly S-R-S arms of a corpus (errors 2e-6 to 2e-3), 1500 poses each at 16 columns, half of them
// 1e-1 to 1e-7 rad from a singularity. UNSURE = 10 loses two more of 46,459 solutions; 160 loses no fewer, at two to
// four times the time. A fortieth loses 47 more.
inline constexpr double UNSURE = 40.0;
// Where the wrist is nearer to the shoulder than this share of the size, the same error turns the line between them more.
inline constexpr double SHORT_LINE = 0.3;
// Where axes nearly align, a bend is tried in this many directions.
inline constexpr int TRIED_AROUND = 8;

struct SrsNear {
    using Arm = SrsArm;
    static constexpr int branches = 16;
    static constexpr bool redundant = true;
    static constexpr int MOST = 4 + 2 * TRIED_AROUND;  // ways of a triple

    // Joint values at which three axes that nearly meet make a given rotation, nearly.
    struct Ways {
        double q[MOST][3];
        int count;
        bool doubtful;
    };

    // Collects starts until a block is full.
    struct StartQueue {
        const Arm& arm;
        const Goal<double>& goal;
        AtSwivel model;
        const Columns<7>& columns;
        Block q[7];
        int column[BLOCK], filled;
        double error;  // imperfection of the ideal arm, larger where the wrist is near the shoulder
        bool wide, failed;
    };

    static PART void solve(const Arm& arm, const Goal<double>& goal, double value, const Reference<7>&, const Columns<7>& columns) {
        const Seen<double> seen = to_frame_1(goal, arm.ideal);
        const Line<double> line = line_to_wrist(seen.p);
        const Swivelled<double> at = swivelled(line, cos_sin_of_any(value));
        StartQueue search = {arm, goal, at_swivel(arm, at), columns, {}, {}, 0, 0.0, false, false};
        search.error = arm.imperfection * max(1.0, SHORT_LINE * arm.written.size / (line.length + TINY));
        const bool doubtful = follow(search, seen, line, at);
        Status status = Srs::status(arm, goal, seen, value, columns);
        if (status == Status::incomplete && (doubtful || search.failed)) {
            search.wide = true;
            follow(search, seen, line, at);
            status = Srs::status(arm, goal, seen, value, columns);
        }
        set_status(columns.flags[0], status);
    }

    // Starts from the ideal arm's solutions; if search.wide, also from joint vectors around its singularities. Returns
    // whether the ideal arm is near one.
    static PART bool follow(StartQueue& search, const Seen<double>& seen, const Line<double>& line, const Swivelled<double>& at) {
        const Arm& arm = search.arm;
        bool doubtful = false;
        for (int way = 0; way < (search.wide ? 4 : 2); ++way) {
            const double up = way & 1 ? -1.0 : 1.0;
            UpperArm<double> elbow = upper_arm(arm, line, at, up);
            if (elbow.margin < -arm.clamp) continue;
            const bool flat = elbow.margin < UNSURE * search.error;
            if (way >= 2) {
                if (!flat) continue;
                // Move the wrist a little towards the middle of the reach, so that the elbow bends.
                const double far = elbow.bend.c > 0.0 ? -1.0 : 1.0;
                elbow = upper_arm(arm, line, at, up, 1.0 + far * 0.1 * UNSURE * search.error);
            }
            const Turn<double> t4 = fourth_turn(arm, elbow);
            const double q4 = wrap(angle(t4));
            const Ways shoulder = ways(search, arm.shoulder, shoulder_rotation(arm, elbow));
            const Ways wrist = ways(search, arm.wrist, wrist_rotation(arm, elbow, t4, seen.R));
            doubtful |= flat || (shoulder.count && wrist.count && (shoulder.doubtful || wrist.doubtful));
            for (int i = 0; i < shoulder.count; ++i) {
                for (int k = 0; k < wrist.count; ++k) {
                    const auto &s = shoulder.q[i], &w = wrist.q[k];
                    add(search, {s[0], s[1], s[2], q4, w[0], w[1], w[2]}, search.wide ? 0 : 4 * i + 2 * (way & 1) + k);
                }
            }
        }
        flush(search);
        return doubtful;
    }

    static PART Ways ways(const StartQueue& search, const MeetingAxes& axes, const Rot<double>& M) {
        const double error = search.error;
        const Twists t = twists_of(axes);
        Ways out = {};
        const Bend<double> bend = wrist_bend(M.z, t, 1.0);
        if (bend.margin < -search.arm.clamp * (error / search.arm.imperfection)) return out;
        const WristTurns<double> turns = wrist_turns(M, bend.turn, t);
        const auto add_way = [&](const Turn<double>& b, bool held, double first) {
            const WristTurns<double> w = wrist_turns(M, b, t, held, cos_sin(first));
            double (&q)[3] = out.q[out.count++];
            q[0] = wrap(angle(w.first)), q[1] = wrap(angle(b) - axes.shift), q[2] = wrap(angle(w.last));
        };
        add_way(bend.turn, false, 0.0), add_way({bend.turn.c, -bend.turn.s}, false, 0.0);
        out.doubtful = min(bend.margin, turns.fixed) < UNSURE * error;
        if (!search.wide || !out.doubtful) return out;
        const double s = sqrt(max(bend.margin, 0.0) + 0.1 * UNSURE * error);
        const Turn<double> more = unit(bend.turn.c, s);
        add_way(more, false, 0.0), add_way({more.c, -more.s}, false, 0.0);
        if (turns.fixed >= UNSURE * error) return out;
        for (int k = 0; k < TRIED_AROUND; ++k) {
            const double first = (2.0 * PI / TRIED_AROUND) * k - PI;
            add_way(more, true, first), add_way({more.c, -more.s}, true, first);
        }
        return out;
    }

    static STEP void add(StartQueue& search, const double (&q)[7], int column) {
        for (int j = 0; j < 7; ++j) search.q[j].set(search.filled, q[j]);
        search.column[search.filled] = column;
        if (++search.filled == BLOCK) flush(search);
    }

    static PART void flush(StartQueue& search) {
        const int many = search.filled;
        search.filled = 0;
        if (!many) return;
        // The rest of the block repeats its first start.
        for (int i = many; i < BLOCK; ++i) {
            for (int j = 0; j < 7; ++j) search.q[j].set(i, search.q[j][0]);
        }
        const Course course = search.wide ? Course{20, CONVERGED, PATIENCE} : Course{12, CONVERGED, 2};
        const auto out = polish_block<true>(search.model, spread<Block>(search.goal), search.q, course);
        for (int i = 0; i < many; ++i) {
            double q[7];
            for (int j = 0; j < 7; ++j) q[j] = search.q[j][i];
            double error = out.error[i];
            // Next to a fold an error below the tolerance still leaves a joint 1e-5 rad off: go on until it converges.
            if (error > CONVERGED && error <= search.model.tolerances.reach) {
                error = polish_one<true>(search.model, search.goal, q, {20, CONVERGED, PATIENCE}).error;
            }
            keep_solution(search, q, error, out.least[i], search.column[i]);
        }
    }

    // least: a lower bound on the Jacobian's smallest singular value near q.
    static PART void keep_solution(StartQueue& search, const double (&q)[7], double error, double least, int column) {
        const Tolerances& tol = search.model.tolerances;
        // Results of a wide search must converge to rounding: beside a fold just out of reach, errors fall below the tolerance.
        if (!(error <= (search.wide ? CONVERGED : tol.reach)) || !is_new(search.model, search.goal, search.columns, q)) {
            search.failed = true;
            return;
        }
        const bool singular = least < NEAR_FOLD && weakest_at(search.model, search.goal, q).value <= tol.singular;
        if (singular && continues(search, q)) return;
        keep(search.columns, column, q, singular ? OTHER : 0);
    }

    // Whether q lies on the continuum of a kept solution: the arm is in the pose at their midpoint too.
    static PART bool continues(const StartQueue& search, const double (&q)[7]) {
        for (int b = 0; b < search.columns.many; ++b) {
            if (!(search.columns.flags[b] & OTHER)) continue;
            double middle[7];
            for (int j = 0; j < 7; ++j) middle[j] = wrap(q[j] - 0.5 * wrap(q[j] - search.columns.row(b)[j]));
            if (missed_by(search.model, search.goal, middle) <= search.model.tolerances.fold) return true;
        }
        return false;
    }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
