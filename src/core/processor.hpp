// Which instruction sets this processor runs, and the one in use.
#pragma once

#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

namespace urdf_ik {

bool runs(const std::string& name);

// Of what was compiled for several instruction sets, the least demanding first: that of the most demanding one that the processor
// runs, or of the one that the environment variable URDF_IK_ISA names. Throws if there is none.
template <class Built, std::size_t many> const Built& in_use(const Built* const (&built)[many]) {
    const char* variable = std::getenv("URDF_IK_ISA");
    const std::string wanted = variable ? variable : "";
    const Built* best = nullptr;
    std::string all;
    for (const Built* each : built) {
        if (!runs(each->name)) continue;
        all += (all.empty() ? "" : ", ") + std::string(each->name);
        if (wanted.empty() || wanted == each->name) best = each;
    }
    if (best) return *best;
    if (!wanted.empty())
        throw std::invalid_argument("URDF_IK_ISA is '" + wanted + "'; this processor runs, of what was built: " + all);
    throw std::runtime_error("this build of urdf_ik._core has no code for this processor");
}

}  // namespace urdf_ik
