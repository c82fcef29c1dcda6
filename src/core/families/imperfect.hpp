// Arms near a family.
#pragma once

#include "../blocks.hpp"
#include "imperfect_arm.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// All branches of a block of targets, beyond their ends too.
struct Candidates {
    Block q[8][6];
    Clearance<Block> clear[8];
    STEP void set(int b, const Block (&angles)[6], const MaskOf<Block>&, const MaskOf<Block>&, const Clearance<Block>& near) {
        for (int j = 0; j < 6; ++j) q[b][j] = angles[j];
        clear[b] = near;
    }
    STEP void leave_open() {
        for (int b = 0; b < 8; ++b) {
            for (int j = 0; j < 6; ++j) q[b][j] = __builtin_nan("");
            clear[b] = {__builtin_nan(""), 0.0};
        }
    }
};

#ifdef RIG
extern "C" { double rig_c = 2.0, rig_k = 0.5, rig_b = 1.0; int rig_rounds = 4; long rig_stat[16]; }
#endif

template <class Family> struct Imperfect {
    using Arm = ImperfectArm<typename Family::Arm>;
    static constexpr int branches = 16, groups = 8 / BLOCK;

    // A group of branches of one pose side by side, each with a target of its own for the ideal arm.
    struct Group {
        Block q[6], ahead, fixed;
        Block open;  // 1 where nothing is decided yet
#ifdef RIG
        Block why;
#endif
        Block found; // 1 where a solution is
    };

    static PART void answer(const Arm& arm, const Seen<Block>& seen, int first, Group& to) {
        Candidates all;
        Family::fast(arm.family, seen, all);
        for (int l = 0; l < BLOCK; ++l) {
            for (int j = 0; j < 6; ++j) to.q[j].set(l, all.q[first + l][j][l]);
            to.ahead.set(l, all.clear[first + l].ahead[l]);
            to.fixed.set(l, all.clear[first + l].fixed[l]);
        }
    }

    // The target that the ideal arm must take for the arm as written to be in `goal` at q: I(q) W(q)^-1 goal.
    static STEP Seen<Block> corrected(const Arm& arm, const Goal<Block>& goal, const Block (&q)[6]) {
        const Frame<Block> W = place(arm.inner, q).tip, I = place(arm.ideal, q).tip;
        // W^-1 goal first.
        const auto back = [&](const Vec<Block>& a) { return Vec<Block>{dot(W.R.x, a), dot(W.R.y, a), dot(W.R.z, a)}; };
        return {{I.R * back(goal.R.x), I.R * back(goal.R.y), I.R * back(goal.R.z)}, I.p + I.R * back(goal.p - W.p)};
    }

    static PART void decide(const Arm& arm, const Goal<Block>& goal, int first, Group& g) {
        Block before[6], moved = 0.0, last = 0.0;
        for (int j = 0; j < 6; ++j) before[j] = g.q[j];
        Group now;
        answer(arm, corrected(arm, goal, before), first, now);
        for (int j = 0; j < 6; ++j) last = max(last, abs(wrap(now.q[j] - before[j])));
        const Block carried = arm.drift / sqrt(now.fixed);
        const Block far = (2.0 * last + arm.steepest * carried);
        const auto open = g.open > Block(0.5);
        const auto beyond = (now.ahead < -rig_b * carried * far - 1e-12) & (carried < Block(0.1));
        Block q[6];
        for (int j = 0; j < 6; ++j) q[j] = now.q[j];
        const Polished<Block> end = polish<false>(arm.inner, goal, q, {5, CONVERGED, 2}, open & !beyond);
        for (int j = 0; j < 6; ++j) moved = max(moved, abs(wrap(q[j] - now.q[j])));
        const auto good = (end.error <= Block(CONVERGED)) & (moved <= rig_k * end.least) & (end.least >= Block(max(rig_c * arm.drift, 1e-5))) &
                          (now.ahead > Block(0.0));
        const auto found = open & !beyond & good;
        for (int j = 0; j < 6; ++j) g.q[j] = select(found, q[j], select(open, now.q[j], g.q[j]));
        g.found = select(found, 1.0, g.found);
        g.open = select(open & !beyond & !found, Block(1.0), Block(0.0));
#ifdef RIG
        for (int l = 0; l < BLOCK; ++l) {
            if (!(g.open[l] > 0.5)) { g.why.set(l, 0); continue; }
            int w = 0;
            if (now.ahead[l] <= 0) w = carried[l] >= 0.1 ? 1 : 2;
            else if (!(end.error[l] <= CONVERGED)) w = 3;
            else if (!(moved[l] <= rig_k * end.least[l])) w = 4;
            else w = 5;
            g.why.set(l, w);
        }
#endif
    }

    static void solve(const Arm& arm, const Goal<double>& goal, const Reference<6>&, const Columns<6>& columns) {
        const double T[16] = {goal.R.x.x, goal.R.y.x, goal.R.z.x, goal.p.x, goal.R.x.y, goal.R.y.y, goal.R.z.y, goal.p.y,
                              goal.R.x.z, goal.R.y.z, goal.R.z.z, goal.p.z, 0, 0, 0, 1};
        const Seen<double> s = to_frame_1<double>(T, arm.family.ideal);
        const Goal<Block> seen = spread<Block>({s.R, s.p});
        int open = 0, count = 0, mask = 0;
        for (int k = 0; k < groups; ++k) {
            Group g;
            answer(arm, {seen.R, seen.p}, k * BLOCK, g);
            g.open = 1.0, g.found = 0.0;
            for (int round = 0; round < rig_rounds && any(g.open > Block(0.5)); ++round) decide(arm, seen, k * BLOCK, g);
            for (int l = 0; l < BLOCK; ++l) {
                open += g.open[l] > 0.5;
#ifdef RIG
                if (g.open[l] > 0.5) mask |= 1 << int(g.why[l]);
#endif
                if (g.found[l] > 0.5) {
                    double q[6];
                    for (int j = 0; j < 6; ++j) q[j] = g.q[j][l];
                    keep(columns, k * BLOCK + l, q, 0), ++count;
                }
            }
        }
        if (open || count % 2) columns.flags[15] = 128 | mask;
    }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
