// The instruction sets for which the solvers were compiled, and the one in use.
#pragma once

#include <string>
#include <vector>

namespace urdf_ik {

// The names of the compiled instruction sets that this processor runs, the least demanding first.
std::vector<std::string> levels_built();

// The most demanding of them, or the one named by the environment variable URDF_IK_ISA. Throws if it is not among them.
std::string level_in_use();

}  // namespace urdf_ik
