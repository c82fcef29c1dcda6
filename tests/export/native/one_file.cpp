// Solves with the exported files of a unit, one after the other: one_file < poses > answers.
// in:  of each arm m, whether values are given, T (m, 16), values (m, parameters)
// out: of each arm q (m, columns, joints), flags (m, columns), the pose at zero (16)
#include "one_file.hpp"

#include <cstdint>
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
    for (const Exported* arm = exported; std::fread(header, 8, 2, stdin) == 2; ++arm) {
        const std::size_t m = std::size_t(header[0]), n = std::size_t(arm->joints), columns = std::size_t(arm->columns);
        const std::size_t p = header[1] ? std::size_t(arm->parameters) : 0;
        double* T = static_cast<double*>(std::malloc(128 * m + 8));
        double* values = static_cast<double*>(std::malloc(8 * m * p + 8));
        double* q = static_cast<double*>(std::calloc(m * columns * n + 1, 8));
        std::uint8_t* flags = static_cast<std::uint8_t*>(std::calloc(m * columns + 1, 1));
        double* zero = static_cast<double*>(std::calloc(7 * n + 16, 8));
        if (!T || !values || !q || !flags || !zero) return 1;
        if (std::fread(T, 128, m, stdin) != m || std::fread(values, 8, m * p, stdin) != m * p) return 1;
        if (arm->ik_batch(T, long(m), q, flags, nullptr, p ? values : nullptr) >= 0) return 1;
        std::fwrite(q, 8, m * columns * n, stdout), std::fwrite(flags, 1, m * columns, stdout);
        arm->fk(zero, zero + n), std::fwrite(zero + n, 8, 16, stdout);
        // The other functions are called, so that they are linked and count what they allocate.
        arm->jacobian(zero, zero + n);
        if (arm->ik(T, q, flags, nullptr, p ? values : nullptr) < 0) return 1;
        std::free(T), std::free(values), std::free(q), std::free(flags), std::free(zero);
    }
    std::fprintf(stderr, "%ld allocations\n", allocations);
    return 0;
}
