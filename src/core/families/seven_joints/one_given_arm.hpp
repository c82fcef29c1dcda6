// Joints, the first or the last of which is given, or one whose axis is that of the next: what is done with it before and after
// the others are solved.
#pragma once

#include "kinematics/arm.hpp"

namespace urdf_ik {

struct GivenJoint {
    // The joint's motion back is their sum times (1, cos, sin) of its value, or, where it slides, the first plus the value
    // times the second. It stands before a target in the base's frame, or behind it in the tip's where the joint is last.
    double motion[3][3][4];
    bool turns, last;
    // Of a joint in the middle whose axis is that of the next one, too: which it is (-1: it stands at an end). The motion is none
    // then, and the next joint takes the value back; opposite: whether it moves the other way.
    int before;
    bool opposite;
    double value;  // where none is given [rad, m]
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
