// The instruction sets that the solvers were compiled for, and the one that is used.
#pragma once

#include <string>
#include <vector>

namespace urdf_ik {

// The names of those that this processor runs, the least demanding first.
std::vector<std::string> levels_built();

// The best of them, or the one that the environment variable URDF_IK_ISA names. Throws if there is no such one.
std::string level_in_use();

}  // namespace urdf_ik
