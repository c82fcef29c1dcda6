// The instruction set that solvers run on: the best that the processor has, or the one that URDF_IK_ISA names.
#pragma once

#include <string>
#include <vector>

#include "../level_table.hpp"

namespace urdf_ik {

const LevelTable& level();
std::vector<std::string> levels_built();

}  // namespace urdf_ik
