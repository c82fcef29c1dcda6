// Arms with one joint given: the first, the last, or one that shares its axis with the next joint. Here are the steps
// before and after the solution of the other joints.
#pragma once

#include "arm/arm.hpp"

namespace urdf_ik {

struct GivenJoint {
    // The inverse of the joint's motion is their sum times (1, cos, sin) of its value; for a slide the first one plus the value
    // times the second one. It multiplies the target from the left, or from the right if the joint is the last one.
    double motion[3][3][4];
    bool turns, last;
    // The index of a middle joint that shares its axis with the next joint; -1 for a joint at an end. The motion is
    // then the identity, and the next joint compensates for the value. opposite: it moves the other way.
    int before;
    bool opposite;
    double value;  // the default [rad, m]
};

struct OneGivenSolvers {
    // Writes the targets for the other joints of part.m poses to T (up to the next multiple of a block), and the given
    // values in the form of the joint vectors to values.
    void (*move)(const GivenJoint&, const Batch& part, double* T, double* values);
    // Inserts the given values into the joint vectors of the other joints and writes the result (part.m, branches,
    // joints) to part.q.
    void (*insert)(const GivenJoint&, const Batch& part, const double* others, const double* values, int joints, int branches);
};
inline constexpr int MOST_LANES = 8;  // of a block, in every instruction set

}  // namespace urdf_ik
