// Solves with exported files: one_file < poses > answers, where ARM_FILE and arm name the arm's header and namespace. A second arm
// in OTHER_FILE shares the unit. in: m, whether values are given, T (m, 16), values (m, parameters); out: q, flags.
#include ARM_FILE
#ifdef OTHER_FILE
#include OTHER_FILE
#endif

#include <cstdio>
#include <cstdlib>
#include <new>

static long allocations = 0;
void* operator new(std::size_t size) {
    ++allocations;
    void* made = std::malloc(size);
    if (!made) std::abort();
    return made;
}
void operator delete(void* held) noexcept { std::free(held); }
void operator delete(void* held, std::size_t) noexcept { std::free(held); }

int main() {
    std::int64_t header[2];
    if (std::fread(header, 8, 2, stdin) != 2) return 1;
    const std::size_t m = std::size_t(header[0]);
    double* T = static_cast<double*>(std::malloc(128 * m + 8));
    double* values = static_cast<double*>(std::malloc(8 * m * arm::parameters + 8));
    double* q = static_cast<double*>(std::malloc(8 * m * arm::columns * arm::joints));
    std::uint8_t* flags = static_cast<std::uint8_t*>(std::malloc(m * arm::columns));
    if (!T || !values || !q || !flags) return 1;
    if (std::fread(T, 128, m, stdin) != m) return 1;
    if (header[1] && std::fread(values, 8, m * arm::parameters, stdin) != m * arm::parameters) return 1;
    if (arm::ik_batch(T, long(m), q, flags, nullptr, header[1] ? values : nullptr) >= 0) return 1;
    std::fwrite(q, 8, m * arm::columns * arm::joints, stdout), std::fwrite(flags, 1, m * arm::columns, stdout);
    double zero[arm::joints] = {}, pose[16];
    arm::fk(zero, pose);
    std::fwrite(pose, 8, 16, stdout);
#ifdef OTHER_FILE
    std::uint8_t marks[other::columns];
    double rest[other::columns * other::joints], start[other::joints] = {};
    other::fk(start, pose);
    if (other::ik(pose, rest, marks) < 1) return 1;
#endif
    std::fprintf(stderr, "%ld allocations\n", allocations);
    std::free(T), std::free(values), std::free(q), std::free(flags);
    return 0;
}
