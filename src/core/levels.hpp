// The solvers of the instruction set in use.
#pragma once

#include "level_table.hpp"
#include "processor.hpp"

namespace urdf_ik { const LevelTable& level(); }  // namespace urdf_ik
