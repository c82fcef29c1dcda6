// See levels.hpp. CMake defines URDF_IK_BUILT_V2 and so on for each instruction set that was compiled.
#include "levels.hpp"

#include <cstdlib>
#include <stdexcept>

#if defined(__x86_64__)
#include <cpuid.h>
#endif

namespace urdf_ik {

namespace v2 { extern const LevelTable table; }
namespace v3 { extern const LevelTable table; }
namespace v4 { extern const LevelTable table; }
namespace arm64 { extern const LevelTable table; }

namespace {

// From the least to the most demanding.
const LevelTable* const built[] = {
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

#if defined(__x86_64__)
// The x86-64 level that processor and operating system offer: by CPUID and XGETBV, since __builtin_cpu_supports answers
// 0 to everything under some compilers. Bits: Intel's manual, volume 2, CPUID.
int processor_level() {
    const auto has = [](unsigned word, unsigned mask) { return (word & mask) == mask; };
    unsigned a, b, c, d, a7, b7, c7, d7, e, f, extended, g;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !__get_cpuid_count(7, 0, &a7, &b7, &c7, &d7)) return 2;
    if (!__get_cpuid(0x80000001, &e, &f, &extended, &g)) return 2;
    const unsigned fma = 1u << 12, movbe = 1u << 22, osxsave = 1u << 27, avx = 1u << 28, f16c = 1u << 29;
    if (!has(c, fma | movbe | osxsave | avx | f16c)) return 2;
    unsigned saved, high;
    __asm__("xgetbv" : "=a"(saved), "=d"(high) : "c"(0));
    const unsigned bmi1 = 1u << 3, avx2 = 1u << 5, bmi2 = 1u << 8, lzcnt = 1u << 5;
    if (!has(saved, 0x6) || !has(extended, lzcnt) || !has(b7, bmi1 | avx2 | bmi2)) return 2;
    const unsigned avx512f = 1u << 16, dq = 1u << 17, cd = 1u << 28, bw = 1u << 30, vl = 1u << 31;
    return has(saved, 0xe6) && has(b7, avx512f | dq | cd | bw | vl) ? 4 : 3;
}
bool runs(const std::string& name) { return name[0] != 'v' || name[1] - '0' <= processor_level(); }
#else
bool runs(const std::string&) { return true; }
#endif

const LevelTable& choose() {
    const char* wanted = std::getenv("URDF_IK_ISA");
    const LevelTable* best = nullptr;
    std::string names;
    for (const LevelTable* each : built) {
        if (!runs(each->name)) continue;
        names += (names.empty() ? "" : ", ") + std::string(each->name);
        if (!wanted || !*wanted || std::string(wanted) == each->name) best = each;
    }
    if (best) return *best;
    if (wanted && *wanted) {
        throw std::invalid_argument("URDF_IK_ISA is '" + std::string(wanted) +
                                    "'; this processor runs, of what was built: " + names);
    }
    throw std::runtime_error("this build of urdf_ik._core has no code for this processor");
}

}  // namespace

const LevelTable& level() {
    static const LevelTable& chosen = choose();
    return chosen;
}

std::vector<std::string> levels_built() {
    std::vector<std::string> names;
    for (const LevelTable* each : built) {
        if (runs(each->name)) names.emplace_back(each->name);
    }
    return names;
}

}  // namespace urdf_ik
