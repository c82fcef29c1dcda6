// Steps for solving an arm on the chain from tip to base, compiled once for every instruction set.
#include "families/closed_forms/reversed.hpp"

#include "numbers/level.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

static void invert_poses(const double* T, long m, double* out) {
    for (long i = 0; i < m; ++i, T += 16, out += 16) {
        for (int r = 0; r < 3; ++r) {
            for (int c = 0; c < 3; ++c) out[4 * r + c] = T[4 * c + r];
            out[4 * r + 3] = -(T[r] * T[3] + T[4 + r] * T[7] + T[8 + r] * T[11]);
        }
        for (int c = 12; c < 16; ++c) out[c] = T[c];
    }
}

template <int N> static STEP void turn_rows(long rows, int joints, double* q) {
    const int n = N ? N : joints;
    for (long i = 0; i < rows; ++i, q += n) {
        for (int j = 0; j < n / 2; ++j) {
            const double x = q[j];
            q[j] = q[n - 1 - j], q[n - 1 - j] = x;
        }
    }
}

static void turn_round(long rows, int joints, double* q, std::uint8_t* flags) {
    if (joints == 6) turn_rows<6>(rows, 6, q);
    else turn_rows<0>(rows, joints, q);
    for (long i = 0; i < rows; ++i) {
        const unsigned f = flags[i], others = f & ~unsigned(SHOULDER | WRIST);
        flags[i] = std::uint8_t(others | (f & SHOULDER ? WRIST : 0) | (f & WRIST ? SHOULDER : 0));
    }
}

extern const ReversedSteps reversed_steps = {invert_poses, turn_round};

}  // namespace urdf_ik::URDF_IK_LEVEL
