// Steps for solving an arm on the chain from tip to base, by pointer for each instruction set.
#pragma once

#include "arm/arm.hpp"

namespace urdf_ik {

struct ReversedSteps {
    // The inverses of rigid motions (m, 4, 4). The last row is copied, so that the solver can check it.
    void (*invert_poses)(const double* T, long m, double* out);
    // Joint vectors (rows, joints) the other way round, in place; shoulder and wrist change places in their flags.
    void (*turn_round)(long rows, int joints, double* q, std::uint8_t* flags);
};

}  // namespace urdf_ik
