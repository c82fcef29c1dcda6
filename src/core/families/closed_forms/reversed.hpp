// What it takes to solve an arm from its other end: steps of each instruction set, plain data.
#pragma once

#include "kinematics/arm.hpp"

namespace urdf_ik {

struct ReversedSteps {
    // The inverses of rigid motions (m, 4, 4). The last row is kept, for whoever checks it.
    void (*invert_poses)(const double* T, long m, double* out);
    // Joint vectors (rows, joints) the other way round, in place; shoulder and wrist change places in their flags.
    void (*turn_round)(long rows, int joints, double* q, std::uint8_t* flags);
};

}  // namespace urdf_ik
