// If rounding leaves open whether a branch exists, the closed form is solved for targets around the pose.
//
// Next to a singularity an angle is accurate to half of its digits only. A second singularity that depends on this angle may then
// be on either side of the computed one, and a free joint may look fixed. Targets a small distance away are not affected. Their
// solutions are near those of the pose, and Newton's method leads from one to the other.
#pragma once

#include "answers/answer.hpp"
#include "kinematics/target.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The distance of these targets [rad, share of size]; their greatest number, in pairs on opposite sides; the search ends after
// IN_VAIN targets in a row without a new solution.
inline constexpr double DISPLACED = 1e-6;
inline constexpr int DISPLACEMENTS = 16, IN_VAIN = 4;

// The k-th of them.
STEP Seen<double> displaced(const Seen<double>& seen, int k, double size) {
    double by[6];
    Scatter scatter = Scatter::number(k / 2);
    for (double& each : by) each = (k % 2 ? DISPLACED : -DISPLACED) * scatter.next();
    // Turn to first order, then make the columns orthonormal.
    const Vec<double> turn = {by[0], by[1], by[2]};
    Vec<double> x = seen.R.x + cross(turn, seen.R.x), y = seen.R.y + cross(turn, seen.R.y);
    x = (1.0 / sqrt(dot(x, x))) * x;
    y = y - dot(x, y) * x;
    y = (1.0 / sqrt(dot(y, y))) * y;
    return {{x, y, cross(x, y)}, seen.p + Vec<double>{size * by[3], size * by[4], size * by[5]}};
}

// The flags of a solution's singularities.
inline constexpr unsigned KINDS = SHOULDER | ELBOW | WRIST | OTHER;

// Whether q, a singular solution of branch b, lies on a continuum with a solution that is already kept. That solution's branch
// differs only in signs that mean nothing there.
template <class Model> PART bool is_represented(const Model& arm, const Goal<double>& goal, const Columns<Model::joints>& columns,
                                                int b, unsigned marks, const double (&q)[Model::joints]) {
    for (int c = 0; c < columns.many; ++c) {
        const unsigned known = columns.flags[c] & KINDS, kinds = marks | known;
        if (!columns.valid(c) || !known) continue;
        const unsigned free = (kinds & SHOULDER ? 4u : 0u) | (kinds & ELBOW ? 2u : 0u) | (kinds & WRIST ? 1u : 0u);
        if ((kinds & OTHER || !(unsigned(b ^ c) & ~free)) && is_joined(arm, goal, q, columns.row(c))) return true;
    }
    return false;
}

// Polish the candidate q of branch b and keep the solution, unless it lies on the continuum of a known one.
template <class Model> PART void keep_unless_represented(const Model& arm, const Goal<double>& goal, double (&q)[Model::joints],
                                                         int b, int marks, const Columns<Model::joints>& columns) {
    if (!holds(arm, goal, q) || !is_new(arm, goal, columns, q)) return;
    const int kinds = singular_marks(arm, goal, q, marks);
    if (!kinds || !is_represented(arm, goal, columns, b, unsigned(kinds), q)) keep(columns, b, q, kinds);
}

// Solve the branches of which Family::closely is unsure from targets around the pose.
template <class Family, int N>
PART void look_around(const typename Family::Arm& arm, const Goal<double>& goal, const Seen<double>& seen,
                      const Reference<N>& reference, const Columns<N>& columns, unsigned unsure) {
    int vain = 0;
    for (int k = 0; unsure && k < DISPLACEMENTS && (vain < IN_VAIN || !columns.count()); ++k) {
        ++vain;
        double room[N * Family::branches];
        std::uint8_t flags[Family::branches];
        const Columns<N> there = {room, flags, Family::branches};
        there.clear();
        Reference<N> from = reference;
        from.displaced = DISPLACED;
        Family::closely(arm, goal, displaced(seen, k, arm.ideal.size), from, there, unsure);
        for (int b = 0; b < there.many; ++b) {
            if (!there.valid(b)) continue;
            const double (&q)[N] = there.row(b);
            const unsigned marks = flags[b] & KINDS;
            if (!is_new(arm.written, goal, columns, q)) continue;
            if (marks && is_represented(arm.written, goal, columns, b, marks, q)) continue;
            keep(columns, b, q, int(marks));
            vain = 0;
        }
    }
}

}  // namespace urdf_ik::URDF_IK_LEVEL
