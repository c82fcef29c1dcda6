// accept() and instances for arms of six joints, compiled once for every instruction set; see answer.hpp.
#include "answers/answer.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

template Polished<double> polish_one<true>(const Written<6>&, const Goal<double>&, double (&)[6], const Course&);
template Polished<Block> polish_block<true>(const Written<6>&, const Goal<Block>&, Block (&)[6], const Course&,
                                            const MaskOf<Block>&);
template Polished<Block> polish_block<false>(const Written<6>&, const Goal<Block>&, Block (&)[6], const Course&,
                                             const MaskOf<Block>&);
template void derivatives_at(const Written<6>&, const Goal<double>&, const double (&)[6], Rows<6, double> (&)[6]);
template double missed_by(const Written<6>&, const Goal<double>&, const double (&)[6]);
template bool is_new(const Written<6>&, const Goal<double>&, const Columns<6>&, const double (&)[6]);
template Weakest<6> weakest_at(const Written<6>&, const Goal<double>&, const double (&)[6]);

void accept(const Written<6>& arm, const Goal<double>& goal, const double (&q)[6], int b, int marks, bool near,
            const Columns<6>& columns) {
    double at[6];
    for (int j = 0; j < 6; ++j) at[j] = q[j];
    // A step along a singular direction does not improve a closed form's candidate: only rounding would cause it.
    const Course course = arm.exact ? Course{15, CONVERGED, LONG_PATIENCE} : Course{60, FINISHED, LONG_PATIENCE};
    const Polished<double> end = polish_one<true>(arm, goal, at, course);
    if (!(end.error <= (arm.exact ? arm.tolerances.reach : CONVERGED)) || !is_new(arm, goal, columns, at)) return;
    // end.least: a lower bound on the smallest singular value of the Jacobian.
    add(arm, goal, columns, b, at, near && end.least < NEAR_FOLD ? singular_marks(arm, goal, at, marks) : 0);
}

}  // namespace urdf_ik::URDF_IK_LEVEL
