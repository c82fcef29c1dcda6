// Arms with one joint given: the first, the last, or one that shares its axis with the next joint. What happens before and after
// the other joints are solved.
#pragma once

#include "kinematics/arm.hpp"

namespace urdf_ik {

struct GivenJoint {
    // The inverse of the joint's motion is their sum times (1, cos, sin) of its value; for a slide the first one plus the value
    // times the second one. It multiplies the target from the left, or from the right if the joint is the last one.
    double motion[3][3][4];
    bool turns, last;
    // The index of a middle joint that shares its axis with the next joint; -1: the joint is at an end. The motion is then the
    // identity, and the next joint takes the value back; opposite: it moves the other way.
    int before;
    bool opposite;
    double value;  // the default [rad, m]
};

struct OneGivenSolvers {
    // Targets of part.m poses as the other joints see them, to T (up to the next multiple of a block), and the values
    // as joint vectors hold them, to values.
    void (*move)(const GivenJoint&, const Batch& part, double* T, double* values);
    // Joint vectors (part.m, branches, joints) with their values before or behind them to part.q.
    void (*insert)(const GivenJoint&, const Batch& part, const double* others, const double* values, int joints, int branches);
};
inline constexpr int MOST_LANES = 8;  // of a block, in every instruction set

}  // namespace urdf_ik
