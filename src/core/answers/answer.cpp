// accept() and instances for arms of six joints, compiled once for every instruction set; see answer.hpp.
#include "answers/answer.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

template Polished<double> polish_one<true>(const Written<6>&, const Goal<double>&, double (&)[6], const Course&);
template Polished<double> polish_one<false>(const Written<6>&, const Goal<double>&, double (&)[6], const Course&);
template Polished<Block> polish_block<true>(const Written<6>&, const Goal<Block>&, Block (&)[6], const Course&,
                                            const MaskOf<Block>&);
template Polished<Block> polish_block<false>(const Written<6>&, const Goal<Block>&, Block (&)[6], const Course&,
                                             const MaskOf<Block>&);
template bool is_new(const Written<6>&, const Goal<double>&, const Columns<6>&, const double (&)[6]);
template Weakest<6> weakest_at(const Written<6>&, const Goal<double>&, const double (&)[6]);

// Starts beside a candidate: itself, then fixed ones 1e-2 to 1e-6 rad away.
static constexpr int STARTS_AROUND_CANDIDATE = 16;

static STEP void start_near_candidate(const double (&q)[6], int k, int lane, Block (&start)[6]) {
    constexpr double widths[3] = {1e-2, 1e-4, 1e-6};
    const double width = k == 0 ? 0.0 : widths[k % 3] * (k < 7 ? 1.0 : 0.3);
    Scatter scatter = Scatter::number(k);
    for (int j = 0; j < 6; ++j) start[j].set(lane, q[j] + width * scatter.next());
}

void accept(const Written<6>& arm, const Goal<double>& goal, const double (&q)[6], int b, int marks, bool near,
            const Columns<6>& columns) {
    if (arm.raw) return keep(columns, b, q, marks);
    const double enough = arm.exact ? arm.tolerances.reach : CONVERGED;
    // least: a lower bound on the smallest singular value of the Jacobian.
    const auto keep_if_new = [&](double (&at)[6], double error, double least) {
        if (!(error <= enough) || !is_new(arm, goal, columns, at)) return;
        add(arm, goal, columns, b, at, near && least < NEAR_FOLD ? singular_marks(arm, goal, at, marks) : 0);
    };
    double at[6];
    // A step along a singular direction does not improve a closed form's candidate: only rounding would cause it.
    const Course course = arm.exact ? Course{15, CONVERGED, LONG_PATIENCE} : Course{60, FINISHED, LONG_PATIENCE};
    if (arm.exact || !arm.beside || !near) {
        for (int j = 0; j < 6; ++j) at[j] = q[j];
        const Polished<double> end = polish_one<true>(arm, goal, at, course);
        return keep_if_new(at, end.error, end.least);
    }
    for (int from = 0; from < STARTS_AROUND_CANDIDATE; from += BLOCK) {
        Block start[6];
        for (int l = 0; l < BLOCK; ++l) start_near_candidate(q, from + l, l, start);
        const Polished<Block> end = polish_block<true>(arm, spread<Block>(goal), start, course);
        for (int l = 0; l < BLOCK; ++l) {
            for (int j = 0; j < 6; ++j) at[j] = wrap(start[j][l]);
            keep_if_new(at, end.error[l], end.least[l]);
        }
    }
}

}  // namespace urdf_ik::URDF_IK_LEVEL
