// See levels.hpp. CMake defines URDF_IK_BUILT_V2 and so on for each instruction set that it builds.
#include "levels.hpp"

namespace urdf_ik {

namespace v2 { extern const LevelTable table; }
namespace v3 { extern const LevelTable table; }
namespace v4 { extern const LevelTable table; }
namespace arm64 { extern const LevelTable table; }

// From the least to the most demanding.
static constexpr const LevelTable* TABLES[] = {
#if defined(URDF_IK_BUILT_V2)
    &v2::table,
#endif
#if defined(URDF_IK_BUILT_V3)
    &v3::table,
#endif
#if defined(URDF_IK_BUILT_V4)
    &v4::table,
#endif
#if defined(URDF_IK_BUILT_ARM64)
    &arm64::table,
#endif
};

std::vector<std::string> levels_built() {
    std::vector<std::string> names;
    for (const LevelTable* each : TABLES) {
        if (runs(each->name)) names.emplace_back(each->name);
    }
    return names;
}

const LevelTable& level() {
    static const LevelTable& chosen = in_use(TABLES);
    return chosen;
}

}  // namespace urdf_ik
