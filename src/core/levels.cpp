// See levels.hpp.
#include "levels.hpp"

namespace urdf_ik {

namespace v2 { extern const LevelTable table; }
namespace v3 { extern const LevelTable table; }
namespace v4 { extern const LevelTable table; }
namespace arm64 { extern const LevelTable table; }

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

static const LevelTable& table_in_use() {
    const std::string name = level_in_use();
    const LevelTable* found = nullptr;
    for (const LevelTable* each : TABLES) {
        if (name == each->name) found = each;
    }
    return *found;  // level_in_use() returns only names that were built
}

const LevelTable& level() {
    static const LevelTable& chosen = table_in_use();
    return chosen;
}

}  // namespace urdf_ik
