// What is known about one pose's solutions: whether they are proven to be all, and how many complex ones there can be.
#pragma once

#include "arm/arm.hpp"

namespace urdf_ik {

// The status stands in two bits of the flags of a pose's first column, solution or not. UNCERTAIN is one of them: it is set where
// nothing proves that the solutions are all.
//   complete    every solution is there, once
//   clustered   every solution is counted; of a group of close ones, whose number the rounding of the pose decides, one or several
//               are given
//   continuum   a curve of solutions keeps the pose; its representatives are there, and isolated solutions may be missing
//   incomplete  solutions may be missing
enum class Status : std::uint8_t { complete = 0, incomplete = UNCERTAIN, clustered = 64, continuum = 64 | UNCERTAIN };
inline constexpr std::uint8_t STATUS_BITS = 64 | UNCERTAIN;

inline Status status_of(std::uint8_t first_flags) { return static_cast<Status>(first_flags & STATUS_BITS); }

// Replaces the status of a pose. It is set last: sorting the columns would move it.
inline void set_status(std::uint8_t& first_flags, Status status) {
    first_flags = std::uint8_t((first_flags & ~STATUS_BITS) | static_cast<std::uint8_t>(status));
}

// Why there are no more isolated complex solutions than Expected::many, counted by multiplicity: nothing is proven; six turning
// joints have at most 16 (Primrose 1986); the stored axes are exactly those of a special family; of the real ones: each is a zero
// of a determinant (certify/circle.hpp).
enum class Why : std::uint8_t { unproven, theorem, family, zeros };

struct Expected {
    int many;
    Why why;
};

}  // namespace urdf_ik
