// Seven joints, the first or the last of which is given, or one whose axis is the next one's too: what is done with it before
// and after the six others are solved.
#pragma once

#include "../arm.hpp"

namespace urdf_ik {

struct GivenJoint {
    // The joint's motion back is their sum times (1, cos, sin) of its value, or, where it slides, the first plus the value
    // times the second. It stands before a target in the base's frame, or behind it in the tip's where the joint is last.
    double motion[3][3][4];
    bool turns, last;
    int at;         // which joint it is
    // Of a joint in the middle, which is none of its motion: the joint with the same axis, which takes the value back, and whether
    // it moves the other way. partner: -1 of a joint at an end.
    int partner;
    bool opposite;
    double value;  // where none is given [rad, m]
};

struct OneGivenSolvers {
    // Targets of part.m poses as the six other joints see them, to T (up to the next multiple of a block), and the values
    // as joint vectors hold them, to values.
    void (*move)(const GivenJoint&, const Batch& part, double* T, double* values);
    // Joint vectors (part.m, branches, 6) with their values before or behind them to part.q.
    void (*insert)(const GivenJoint&, const Batch& part, const double* six, const double* values, int branches);
};
inline constexpr int MOST_LANES = 8;  // of a block, in every instruction set

}  // namespace urdf_ik
