// Numbers that look random and are always the same.
#pragma once

#include <cstdint>

#include "numbers/level.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Pseudorandom numbers in [-1, 1), always the same, so that equal targets have equal answers: the linear congruential generator
// of the C standard's example.
struct Scatter {
    std::uint32_t seed;
    STEP double next() {
        seed = (seed * 1103515245u + 12345u) & 0x7fffffffu;
        return seed / 1073741824.0 - 1.0;
    }
    // The k-th of several sequences.
    static STEP Scatter number(int k) { return {12345u + 7919u * std::uint32_t(k)}; }
};

}  // namespace urdf_ik::URDF_IK_LEVEL
