// Solves what a test asks for: solve ARM.json < poses > answers. All numbers are native doubles and 64-bit integers.
// in:  m, whether values are given, whether a reference is; T (m, 16), values (m, parameters), q_ref (joints)
// out: q (m, columns, joints), status, nearest column and number of turns (m, 3), nearest (m, joints); of each pose's first
// solution
//      pose (m, 16), Jacobian (m, 6, joints), redundancy (m, parameters), four images (m, 4, joints); flags (m, columns)
#include <urdf_ik.hpp>

#include <cstdio>
#include <cstdlib>
#include <new>
#include <vector>

// Counted while the arm is used.
static long allocations = 0;
void* operator new(std::size_t size) {
    ++allocations;
    void* made = std::malloc(size);
    if (!made) std::abort();
    return made;
}
void operator delete(void* held) noexcept { std::free(held); }
void operator delete(void* held, std::size_t) noexcept { std::free(held); }

template <class T> static std::vector<T> read(std::size_t count) {
    std::vector<T> numbers(count);
    if (std::fread(numbers.data(), sizeof(T), count, stdin) != count) std::exit(std::fprintf(stderr, "input ends early\n"));
    return numbers;
}
template <class T> static void write(const std::vector<T>& numbers) {
    std::fwrite(numbers.data(), sizeof(T), numbers.size(), stdout);
}

int main(int, char** argv) {
    std::string error;
    const urdf_ik::Arm arm = urdf_ik::Arm::load(argv[1], &error);
    if (!arm) return std::fprintf(stderr, "%s\n", error.c_str()), 1;
    const auto header = read<std::int64_t>(3);
    const std::size_t m = std::size_t(header[0]), n = std::size_t(arm.joints()), columns = std::size_t(arm.columns());
    const std::size_t p = std::size_t(arm.parameters());
    const auto T = read<double>(16 * m), values = read<double>(header[1] ? m * p : 0), q_ref = read<double>(header[2] ? n : 0);
    const double nan = __builtin_nan("");
    std::vector<double> q(m * columns * n), nearest(m * n, nan), pose(16 * m, nan), J(6 * n * m, nan), free(m * p, nan);
    std::vector<double> images(4 * n * m, nan), zeros(n);
    std::vector<std::int64_t> numbers(3 * m);
    std::vector<std::uint8_t> flags(m * columns);
    const double* reference = header[2] ? q_ref.data() : zeros.data();
    const long before = allocations;
    if (arm.ik(T.data(), long(m), q.data(), flags.data(), header[2] ? q_ref.data() : nullptr,
               header[1] ? values.data() : nullptr) >= 0)
        return std::fprintf(stderr, "no pose\n"), 1;
    for (std::size_t i = 0; i < m; ++i) {
        const std::uint8_t* marks = &flags[i * columns];
        numbers[3 * i] = int(urdf_ik::Arm::status(marks));
        numbers[3 * i + 1] = arm.nearest(&q[i * columns * n], marks, reference, &nearest[i * n]);
        numbers[3 * i + 2] = -1;
        for (std::size_t c = 0; c < columns; ++c) {
            if (!urdf_ik::Arm::valid(marks[c])) continue;
            const double* row = &q[(i * columns + c) * n];
            arm.fk(row, 1, &pose[16 * i]), arm.jacobian(row, 1, &J[6 * n * i]);
            arm.redundancy_of(row, &T[16 * i], free.data() + i * p);
            numbers[3 * i + 2] = arm.turns(row, &images[4 * n * i], 4);
            break;
        }
    }
    std::fprintf(stderr, "%ld allocations\n", allocations - before);
    write(q), write(numbers), write(nearest), write(pose), write(J), write(free), write(images), write(flags);
}
