// Drives all closed forms: a block of poses is checked, transformed, solved and stored. Poses in doubt (near a singularity, at the
// edge of reach, with an inexact rotation) are then solved one by one on a careful path.
//
// A Family is a struct with
//   Arm        an arm's numbers; Arm::ideal is IdealFrames, or Ends at least, Arm::written is Written<N>
//   branches   the number of columns
//   fast       fast(arm, seen, found): all branches of a block of poses; found is Found<branches>. A family with signs that lacks
//              it is driven by solve_branches(), one branch after the other
//   by_signs   whether three signs distinguish its branches; if so
//   branch     branch(arm, seen, signs): one branch and one pose per lane, on numbers or on balls; numbers also beyond a
//              branch's end (see margin_root)
// and, if its targets are not poses of sixteen numbers,
//   numbers    the length of a target
//   load       load(arm, from, t): a block of targets as poses
// and, for arms with a redundancy parameter,
//   redundant  true; Arm::value is its default; fast, closely and solve take it after `seen`
//   closely    closely(arm, goal, seen, value, reference, columns, wanted): the branches of one pose whose bit is set in
//              `wanted`, added to the columns
//   status     status(arm, goal, seen, value, columns) of a pose that closely has solved
// A family with neither is driven by solve_singly, one pose after the other. It has
//   solve      solve(arm, goal, reference, columns): all solutions of one pose
// or branch, and
//   quartic    quartic(arm, seen): the roots that its branches follow from
//   root_bit, root_joint: see proposals.hpp
#pragma once

#include "arm/target.hpp"
#include "families/rooted.hpp"
#include "propose/answer.hpp"
#include "propose/branch.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// For one or several branches: the lanes in which they are not solutions, the lanes in which this is in doubt, and the lanes in
// which rounding may have changed it (see Clear).
struct State {
    MaskOf<Block> lost, doubt, close;
};

// The result for a block: angles of each branch, the lanes in which it is a solution, and the lanes in doubt; and the lanes whose
// poses need a proof from elsewhere that their branches are all.
template <int B, int N = 6> struct Found {
    Block q[B][N];
    unsigned valid[B], doubt[B], unproven = 0;

    // Angles where the branch is neither lost nor in doubt, NaN elsewhere.
    STEP void set(int b, const Block (&angles)[N], const MaskOf<Block>& lost, const MaskOf<Block>& in_doubt) {
        const auto good = !(lost | in_doubt);
        for (int j = 0; j < N; ++j) q[b][j] = select(good, angles[j], __builtin_nan(""));
        valid[b] = bits(good), doubt[b] = bits(in_doubt & !lost);
    }
};

// Angles of a block, given by (cos, sin), that are computed together.
template <int N> struct AnglesOf {
    Block y[N], x[N];
    STEP void set(int i, const Turn<Block>& t) { y[i] = t.s, x[i] = t.c; }
};
// Angles of y[FROM..TO) and x, to y: four at a time, so that the processor finds independent work.
template <int FROM, int TO> PART void angles(Block* __restrict y, const Block* __restrict x) {
    static_assert((TO - FROM) % 4 == 0);
#pragma GCC unroll 1
    for (int i = FROM; i < TO; i += 4) {
        Block a[4];
#pragma GCC unroll 4
        for (int k = 0; k < 4; ++k) a[k] = atan2(y[i + k], x[i + k]);
#pragma GCC unroll 4
        for (int k = 0; k < 4; ++k) y[i + k] = a[k];
    }
}

// Loads as many poses as the block has lanes into sixteen registers.
template <int L> STEP void load_poses(const double* T, Pack<L, 1> (&t)[16]) {
    for (int c = 0; c < 16; c += L) {
        typename Register<L>::type r[L];
        for (int l = 0; l < L; ++l) r[l] = *(const typename Register<L>::unaligned*)(T + 16 * l + c);
        transpose<L>(r);
        for (int l = 0; l < L; ++l) t[c + l].r[0] = r[l];
    }
}

// Streaming stores bypass the cache: they are faster if the answer does not fit in it, and slower if it is read at once.
enum class Write { plain, streaming };
inline constexpr long STREAMED_FROM = 10000;  // poses

template <Write how, int L> STEP void put(double* to, const typename Register<L>::type& x) {
#if defined(__x86_64__)
    if constexpr (how == Write::streaming) {
#if defined(__AVX512F__)
        if constexpr (L == 8) return _mm512_stream_pd(to, (__m512d)x);
#endif
#if defined(__AVX__)
        if constexpr (L == 4) return _mm256_stream_pd(to, (__m256d)x);
#endif
        if constexpr (L == 2) return _mm_stream_pd(to, (__m128d)x);
    }
#endif
    *(typename Register<L>::unaligned*)to = x;
}

// Store COUNT packs with one pose per lane as COUNT consecutive numbers per pose; numbers that do not fill whole registers by way
// of the cache.
template <Write how, int COUNT, int L> STEP void store_rows(const Pack<L, 1> (&rows)[COUNT], double* to) {
    if constexpr (COUNT % L) {
        double* row[L];
        for (int l = 0; l < L; ++l) row[l] = to + COUNT * l;
        store_rows(rows, row);
    } else {
#pragma GCC unroll 8
        for (int c = 0; c < COUNT; c += L) {
            typename Register<L>::type r[L];
            for (int l = 0; l < L; ++l) r[l] = rows[c + l].r[0];
            transpose<L>(r);
            for (int l = 0; l < L; ++l) put<how, L>(to + COUNT * l + c, r[l]);
        }
    }
}

// Eight bits to eight bytes of 0 or 1.
STEP std::uint64_t bytes_of(unsigned eight) {
    const std::uint64_t each = (eight * 0x0101010101010101ULL) & 0x8040201008040201ULL;
    return ((each + 0x7f7f7f7f7f7f7f7fULL) >> 7) & 0x0101010101010101ULL;
}

// Bit `lane` of each of the branches' masks, branch 0 lowest.
template <int B> STEP unsigned of_lane(const unsigned (&masks)[B], int lane) {
    unsigned r = 0;
    for (int b = 0; b < B; ++b) r |= (masks[b] >> lane & 1u) << b;
    return r;
}

// Eight rows of eight bits to columns: blocks of 1, 2 and 4 change places (Warren, Hacker's Delight, section 7-3).
STEP std::uint64_t transposed_bits(const unsigned (&rows)[8]) {
    std::uint64_t x = 0, t;
    for (int b = 0; b < 8; ++b) x |= std::uint64_t(rows[b]) << 8 * b;
    t = (x ^ x >> 7) & 0x00aa00aa00aa00aaULL, x ^= t ^ t << 7;
    t = (x ^ x >> 14) & 0x0000cccc0000ccccULL, x ^= t ^ t << 14;
    t = (x ^ x >> 28) & 0x00000000f0f0f0f0ULL, x ^= t ^ t << 28;
    return x;
}
STEP void store_flags(const unsigned (&valid)[8], int many, std::uint8_t* flags) {
    const std::uint64_t lanes = transposed_bits(valid);
    for (int i = 0; i < many; ++i) {
        const std::uint64_t bytes = bytes_of(unsigned(lanes >> 8 * i) & 255u);
        __builtin_memcpy(flags + 8 * i, &bytes, 8);
    }
}
template <int B> STEP void store_flags(const unsigned (&valid)[B], int many, std::uint8_t* flags) {
    for (int i = 0; i < many; ++i) {
        const unsigned all = of_lane(valid, i);
        for (int b = 0; b < B; b += 8) {
            const std::uint64_t bytes = bytes_of(all >> b & 255u);
            __builtin_memcpy(flags + B * i + b, &bytes, unsigned(B - b < 8 ? B - b : 8));
        }
    }
}

// A block's answers to a batch.
template <int B, int N> PART void store_block(const Found<B, N>& found, const Batch& to, Write how) {
    const auto& rows = reinterpret_cast<const Block(&)[N * B]>(found.q);
    if (how == Write::streaming) store_rows<Write::streaming>(rows, to.q);
    else store_rows<Write::plain>(rows, to.q);
    store_flags(found.valid, int(to.m), to.flags);
}

template <class Family> inline constexpr int joints_of = decltype(Family::Arm::written)::joints;
template <class Family> constexpr int numbers_of() {
    if constexpr (requires { Family::numbers; }) return Family::numbers;
    else return 16;
}
template <class Family> STEP void load_targets(const typename Family::Arm& arm, const double* from, Block (&t)[16]) {
    if constexpr (requires { Family::numbers; }) Family::load(arm, from, t);
    else load_poses(from, t);
}

template <class Family> constexpr bool redundant_of() {
    return requires { Family::redundant; };
}

// The redundancy parameter of a block of poses.
template <class Arm> STEP Block load_values(const Arm& arm, const double* values) {
    Block v = arm.value;
    for (int i = 0; values && i < BLOCK; ++i) v.set(i, values[i]);
    return v;
}

// All solutions of one pose of an exact arm whose branches have signs, and its status; the columns have those of branches that are
// not in `wanted`.
template <class Family>
PART Status solve_by_signs(const typename Family::Arm& arm, const double (&T)[16], const Reference<6>& reference, unsigned wanted,
                           const Columns<6>& columns) {
    double proper[16];
    project_rotation(T, proper);
    const Goal<double> goal = goal_of(proper);
    const Boxes boxes = boxes_of<Family>(arm, goal, arm.ideal.signs);
    Status status = fill<Family>(arm, goal, to_frame_1(goal, arm.ideal), {}, reference, boxes, wanted, columns);
    if (may_be_joined(boxes, status) && any_is_on_curve(arm.written, goal, columns)) return Status::continuum;
    if (status == Status::incomplete) status = decided_closely<Family>(arm, goal, boxes, columns);
    return status == Status::incomplete ? refer(arm.written, goal, columns) : status;
}

// Solve one pose's branches in doubt on the careful path. value: of the redundancy parameter, for arms that have one.
template <class Family>
PART void solve_in_doubt(const typename Family::Arm& arm, const double (&T)[16], double defect, const double* q_ref, double value,
                         unsigned wanted, const Columns<joints_of<Family>>& columns) {
    double proper[16];
    for (int i = 0; i < 16; ++i) proper[i] = T[i];
    if (defect > arm.written.tolerances.exact_rotation) {
        project_rotation(T, proper);
        columns.clear();
        wanted = ~0u;
    }
    const auto reference = reference_of<joints_of<Family>>(q_ref);
    if constexpr (branches_have_signs<Family>()) {
        set_status(columns.flags[0], solve_by_signs<Family>(arm, T, reference, wanted, columns));
    } else {
        const auto seen = to_frame_1<double>(proper, arm.ideal);
        const Goal<double> goal = goal_of(proper);
        if constexpr (redundant_of<Family>()) {
            Family::closely(arm, goal, seen, value, reference, columns, wanted);
            set_status(columns.flags[0], Family::status(arm, goal, seen, value, columns));
        } else {
            Family::closely(arm, goal, seen, reference, columns, wanted);
        }
    }
}

// All branches of a block of poses by a family's text for one branch. A later step is inaccurate past the end of an earlier one's
// branch, so a branch is lost only if nothing is near its end.
template <class Family>
STEP void solve_branches(const typename Family::Arm& arm, const Goal<Block>& goal, Found<8>& found) {
    const IdealFrames& ideal = arm.ideal;
    const Tolerances& tol = arm.written.tolerances;
    const Seen<Block> seen = to_frame_1(goal, ideal);
    for (int b = 0; b < 8; ++b) {
        Branch<Block> at;
        branch_of_lanes<Family>(arm, seen, {ideal.signs[0][b], ideal.signs[1][b], ideal.signs[2][b]}, at);
        const Block m[3] = {min(abs(at.shoulder), 1.0), min(abs(at.elbow), 1.0), min(abs(at.wrist), 1.0)};
        const Block lever = min(min(at.lever[0], 1.0), min(at.lever[1], at.lever[2])), nearest = min(m[0], min(m[1], m[2]));
        const Block least = min(at.shoulder, min(at.elbow, at.wrist));
        Block q[6];
        for (int j = 0; j < 6; ++j) q[j] = wrap(angle(at.turn[j]) - ideal.offset[j]);
        const auto lost = (least < Block(-tol.edge)) & (min(nearest, lever) > Block(tol.edge));
        const auto doubt =
            (min(least, lever) <= Block(tol.edge)) | !(error_at(arm.written, goal, q).size <= Block(0.1 * tol.reach));
        found.set(b, q, lost, doubt);
        // No less close than by Clear, in whatever order the steps are.
        found.unproven |= bits(m[0] * m[1] * m[2] * nearest * (lever * lever) <= Block(ideal.together));
    }
}

// Solve one block of targets; only the first `part.m` count. Returns the index of the first invalid pose, or -1.
template <class Family> STEP int solve_block(const typename Family::Arm& arm, const Batch& part, Write how) {
    constexpr int B = Family::branches, N = joints_of<Family>;
    const int many = int(part.m);
    Block t[16];
    load_targets<Family>(arm, part.T, t);
    const Block defect = pose_defect(t);
    const unsigned improper = bits(!(defect <= Block(arm.written.tolerances.rotation)));
    if (improper) {
        for (int i = 0; i < many; ++i) {
            if (improper >> i & 1) return i;
        }
    }
    Found<B, N> found;
    Block value = 0.0;
    if constexpr (redundant_of<Family>()) {
        value = load_values(arm, part.values);
        Family::fast(arm, to_frame_1(t, arm.ideal), value, found);
    } else if constexpr (requires { &Family::fast; }) {
        Family::fast(arm, to_frame_1(t, arm.ideal), found);
    } else {
        solve_branches<Family>(arm, {{{t[0], t[4], t[8]}, {t[1], t[5], t[9]}, {t[2], t[6], t[10]}}, {t[3], t[7], t[11]}}, found);
    }
    store_block(found, part, how);
    unsigned care = bits(defect > Block(arm.written.tolerances.exact_rotation));
    for (int b = 0; b < B; ++b) care |= found.doubt[b];
    care |= found.unproven;
    if (care) [[unlikely]] {
        load_targets<Family>(arm, part.T, t);
        for (int i = 0; i < many; ++i) {
            if (!(care >> i & 1)) continue;
            double T[16];
            for (int k = 0; k < 16; ++k) T[k] = t[k][i];
            const Columns<N> columns = {part.q + N * B * i, part.flags + B * i, B};
            solve_in_doubt<Family>(arm, T, defect[i], part.q_ref, value[i], of_lane(found.doubt, i), columns);
        }
    }
    return -1;
}

// The joint vectors of all branches of a batch, also beyond their ends: see Batch::beyond. columns: per pose, eight or more.
template <class Family> PART void branches_beyond(const typename Family::Arm& arm, const Batch& batch, int columns) {
    for (long i = 0; i < batch.m; ++i) {
        double* to = batch.q + 6 * columns * i;
        for (int k = 0; k < 6 * columns; ++k) to[k] = __builtin_nan("");
        if constexpr (branches_have_signs<Family>()) {
            const Seen<Block> seen = to_frame_1(spread<Block>(goal_of(batch.T + 16 * i)), arm.ideal);
            for (int first = 0; first < 8; first += BLOCK) {
                const Branch<Block> at = branches_from<Family>(arm, seen, first, arm.ideal.signs);
                for (int j = 0; j < 6; ++j) {
                    const Block q = wrap(angle(at.turn[j]) - arm.ideal.offset[j]);
                    for (int l = 0; l < BLOCK; ++l) to[6 * (first + l) + j] = q[l];
                }
            }
        }
    }
}
// Whether branches_beyond() applies to the family.
template <class Family> constexpr bool has_ends() {
    return requires { Family::by_signs; };
}

// All solutions of a batch. Returns the index of the first invalid pose, or -1.
template <class Family> long solve_closed_form(const typename Family::Arm& arm, const Batch& batch) {
    constexpr int B = Family::branches, answers = joints_of<Family> * B, numbers = numbers_of<Family>();
    if constexpr (has_ends<Family>()) {
        if (batch.beyond) return branches_beyond<Family>(arm, batch, B), -1;
    }
    const bool aligned = reinterpret_cast<std::uintptr_t>(batch.q) % sizeof(typename Register<8>::type) == 0;
    const Write how = (batch.m >= STREAMED_FROM || batch.whole >= STREAMED_FROM) && aligned ? Write::streaming : Write::plain;
    double T[numbers * BLOCK], values[BLOCK];
    alignas(64) double q[answers * BLOCK];
    for (long start = 0; start < batch.m; start += BLOCK) {
        const int many = batch.m - start < BLOCK ? int(batch.m - start) : BLOCK;
        Batch part = {
            batch.T + numbers * start, many, batch.q_ref, batch.values ? batch.values + start : nullptr, batch.q + answers * start,
            batch.flags + B * start};
        if (many < BLOCK) {
            // The last block repeats its last target, so that the same instructions handle a pose wherever it is in a batch.
            for (int i = 0; i < BLOCK; ++i) {
                const long from = start + (i < many ? i : many - 1);
                __builtin_memcpy(T + numbers * i, batch.T + numbers * from, numbers * sizeof(double));
                values[i] = batch.values ? batch.values[from] : 0.0;
            }
            part.T = T, part.values = batch.values ? values : nullptr, part.q = q;
        }
        const int bad = solve_block<Family>(arm, part, how);
        if (bad >= 0) return start + bad;
        if (many < BLOCK) __builtin_memcpy(batch.q + answers * start, q, sizeof(double) * unsigned(answers * many));
    }
#if defined(__x86_64__)
    if (how == Write::streaming) _mm_sfence();
#endif
    return -1;
}

// The same for families without a fast path, one pose after the other.
template <class Family> long solve_singly(const typename Family::Arm& arm, const Batch& batch) {
    constexpr int B = Family::branches, N = joints_of<Family>;
    if constexpr (requires { &Family::beyond_ends; }) {
        if (batch.beyond) return Family::beyond_ends(arm, batch), -1;
    }
    const Reference<N> reference = reference_of<N>(batch.q_ref);
    for (long i = 0; i < batch.m; ++i) {
        double T[16], proper[16];
        for (int k = 0; k < 16; ++k) T[k] = batch.T[16 * i + k];
        if (!(pose_defect<double>(T) <= arm.written.tolerances.rotation)) return i;
        project_rotation(T, proper);
        const Columns<N> columns = {batch.q + N * B * i, batch.flags + B * i, B};
        columns.clear();
        if constexpr (redundant_of<Family>()) {
            Family::solve(arm, goal_of(proper), batch.values ? batch.values[i] : arm.value, reference, columns);
        } else if constexpr (has_quartic<Family>()) {
            set_status(columns.flags[0], solve_by_roots<Family>(arm, goal_of(proper), reference, columns));
        } else {
            Family::solve(arm, goal_of(proper), reference, columns);
        }
    }
    return -1;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
