// The solvers of the instruction set in use.
#pragma once

#include "level_table.hpp"
#include "processor.hpp"

namespace urdf_ik {

// The names of the compiled instruction sets that this processor runs, the least demanding first.
std::vector<std::string> levels_built();

const LevelTable& level();

}  // namespace urdf_ik
