// Arms with an end joint given: T' = E1(v)^-1 T for the first joint, T' = T En(v)^-1 for the last one. The other joints
// form the same arm for every value; only their targets move. A free rotation of the target about an axis of the tip
// works alike. If two neighbouring joints share an axis, the first of them may be given too: the other one compensates
// for its value.
#include "families/blocks.hpp"
#include "families/seven_joints/one_given_arm.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

static_assert(BLOCK <= MOST_LANES);

static STEP void move_block(const GivenJoint& given, const double* from, const Block& value, double* to) {
    Block t[16], out[16], B[3][4];
    load_poses(from, t);
    const Turn<Block> by = given.turns ? cos_sin_of_any(value) : Turn<Block>{value, 0.0};
    const auto& m = given.motion;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 4; ++j) B[i][j] = m[0][i][j] + by.c * m[1][i][j] + by.s * m[2][i][j];
    }
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 4; ++j) {
            if (given.last) {
                out[4 * i + j] = t[4 * i] * B[0][j] + t[4 * i + 1] * B[1][j] + t[4 * i + 2] * B[2][j];
                if (j == 3) out[4 * i + j] += t[4 * i + 3];
            } else {
                out[4 * i + j] = B[i][0] * t[j] + B[i][1] * t[4 + j] + B[i][2] * t[8 + j];
                if (j == 3) out[4 * i + j] += B[i][3];
            }
        }
    }
    // The last row is copied, so that the solver can check it.
    for (int j = 12; j < 16; ++j) out[j] = t[j];
    store_rows<Write::plain>(out, to);
}

static void move(const GivenJoint& given, const Batch& part, double* T, double* values) {
    for (long i = 0; i < part.m; i += BLOCK) {
        const bool whole = i + BLOCK <= part.m;
        double rest[16 * BLOCK];
        Block value = given.value;
        for (int k = 0; k < BLOCK; ++k) {
            const long from = i + k < part.m ? i + k : part.m - 1;
            if (part.values) value.set(k, principal_value(part.values[from], given.turns));
            if (!whole) __builtin_memcpy(rest + 16 * k, part.T + 16 * from, 16 * sizeof(double));
            if (i + k < part.m) values[i + k] = part.values ? value[k] : principal_value(value[k], given.turns);
        }
        move_block(given, whole ? part.T + 16 * i : rest, value, T + 16 * i);
    }
}

// N: the number of other joints, 0 if unknown at compile time.
template <int N> static STEP void insert_rows(const GivenJoint& given, const Batch& part, const double* others,
                                              const double* values, int joints, int branches) {
    const int n = N ? N : joints, first = given.last ? 0 : 1;
    for (long i = 0; i < part.m; ++i) {
        for (long row = branches * i; row < branches * (i + 1); ++row) {
            const double* from = others + n * row;
            double* to = part.q + (n + 1) * row;
            const double value = part.flags[row] & VALID ? values[i] : __builtin_nan("");
            to[first ? 0 : n] = value;
            __builtin_memcpy(to + first, from, sizeof(double) * unsigned(n));
        }
    }
}

static void insert_before(const GivenJoint& given, const Batch& part, const double* others, const double* values, int n,
                          int branches) {
    const int at = given.before;
    for (long row = 0; row < branches * part.m; ++row) {
        const double value = part.flags[row] & VALID ? values[row / branches] : __builtin_nan("");
        double* to = part.q + (n + 1) * row;
        for (int j = 0; j <= n; ++j) to[j] = j == at ? value : others[n * row + j - (j > at)];
        const double rest = to[at + 1] - (given.opposite ? -value : value);
        to[at + 1] = given.turns ? wrap(rest) : rest;
    }
}

static void insert(const GivenJoint& given, const Batch& part, const double* others, const double* values, int joints,
                   int branches) {
    if (given.before >= 0) insert_before(given, part, others, values, joints, branches);
    else if (joints == 6) insert_rows<6>(given, part, others, values, joints, branches);
    else insert_rows<0>(given, part, others, values, joints, branches);
}

extern const OneGivenSolvers one_given_solvers = {move, insert};

}  // namespace urdf_ik::URDF_IK_LEVEL
