// The solutions of one pose: whether a candidate is new, where it is kept, in what order they stand.
#pragma once

#include "answers/polish.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The columns of one pose in the caller's memory: q (many, N), flags (many).
template <int N> struct Columns {
    double* q;
    std::uint8_t* flags;
    int many;

    STEP double* row(int b) const { return q + N * b; }
    STEP bool valid(int b) const { return flags[b] & VALID; }
    STEP int count() const {
        int n = 0;
        for (int b = 0; b < many; ++b) n += valid(b);
        return n;
    }
    STEP void swap(int a, int b) const {
        for (int j = 0; j < N; ++j) {
            const double x = row(a)[j];
            row(a)[j] = row(b)[j], row(b)[j] = x;
        }
        const std::uint8_t f = flags[a];
        flags[a] = flags[b], flags[b] = f;
    }
    STEP void clear(int b) const {
        for (int j = 0; j < N; ++j) row(b)[j] = __builtin_nan("");
        flags[b] = 0;
    }
    STEP void clear() const {
        for (int b = 0; b < many; ++b) clear(b);
    }
};

// The joint vector near which a joint that a pose leaves free is put: the caller's, or zeros.
template <int N> struct Reference {
    double q[N];
    double given;  // 1, or 0 where it stands for zeros
    // How far the target that a closed form sees stands off the one that is to be reached [rad, share of size].
    double displaced = 0.0;
};
template <int N> STEP Reference<N> reference_of(const double* q_ref) {
    Reference<N> r;
    for (int j = 0; j < N; ++j) r.q[j] = q_ref ? q_ref[j] : 0.0;
    r.given = q_ref ? 1.0 : 0.0;
    return r;
}

// Margins and squared arms up to here may be those of a singular solution, whose Jacobian then decides.
template <int N> STEP double marked(const Tolerances& tolerances, const Reference<N>& reference) {
    return max(tolerances.fold, 10.0 * reference.displaced);
}

// The smallest singular value of the Jacobian at q, and its direction.
template <class Model>
SHARED Weakest<Model::joints> weakest_at(const Model& arm, const Goal<double>& goal, const double (&q)[Model::joints]) {
    Rows<Model::rows, double> J[Model::joints];
    error_and_jacobian(arm, goal, q, J);
    return weakest(J);
}

// Whether q differs from every solution that the columns hold. Two vectors half way between which the arm is still in
// the pose, to rounding, are one double root; two that are no farther apart than their errors over the Jacobian's smallest
// singular value are one root, which neither has come quite to.
template <class Model>
SHARED bool is_new(const Model& arm, const Goal<double>& goal, const Columns<Model::joints>& columns,
                   const double (&q)[Model::joints]) {
    constexpr int N = Model::joints;
    // The pose of a slide many sizes out is rounded as coarsely as it is far.
    double far = 1.0;
    for (int j = 0; j < N; ++j) far = max(far, abs(gap(arm, j, q[j], 0.0)) / PI);
    const double same = arm.tolerances.duplicate * far;
    for (int b = 0; b < columns.many; ++b) {
        if (!columns.valid(b)) continue;
        const double* other = columns.row(b);
        double apart = 0.0, middle[N];
        for (int j = 0; j < N && (apart < BESIDE || apart <= same); ++j) {
            const double step = gap(arm, j, q[j], other[j]);
            middle[j] = advanced(arm, j, other[j], 0.5 * step);
            apart = max(apart, abs(step));
        }
        if (apart <= same) return false;
        if (apart >= BESIDE) continue;
        if (error_at(arm, goal, middle).size <= arm.tolerances.fold * far) return false;
        double known[N];
        for (int j = 0; j < N; ++j) known[j] = other[j];
        const double left = error_at(arm, goal, q).size + error_at(arm, goal, known).size;
        if (left > FINISHED && apart * weakest_at(arm, goal, q).value <= left) return false;
    }
    return true;
}

// Store q in column b, or in the first free one if that is taken; a full table drops it.
template <int N> STEP void keep(const Columns<N>& columns, int b, const double (&q)[N], int marks) {
    if (columns.valid(b)) {
        for (b = 0; b < columns.many && columns.valid(b); ++b) {}
        if (b == columns.many) return;
    }
    for (int j = 0; j < N; ++j) columns.row(b)[j] = q[j];
    columns.flags[b] = VALID | marks;
}

// Joint values nearer than this [rad, m] count as the same in the order of the columns, so that rounding does not
// decide it.
inline constexpr double SAME_VALUE = 1e-6;

// Order the solutions by their joint values, the first joint first, the invalid ones behind: columns of an arm whose
// branches have no names stand in the same order for every way of finding them.
template <int N> PART void sort(const Columns<N>& columns) {
    const auto before = [&](int a, int b) {
        if (columns.valid(a) != columns.valid(b)) return columns.valid(a);
        if (!columns.valid(a)) return false;
        for (int j = 0; j < N; ++j) {
            if (abs(columns.row(a)[j] - columns.row(b)[j]) > SAME_VALUE) return columns.row(a)[j] < columns.row(b)[j];
        }
        return false;
    };
    for (int i = 1; i < columns.many; ++i) {
        for (int k = i; k > 0 && before(k, k - 1); --k) columns.swap(k, k - 1);
    }
}

// The second smallest singular value of the Jacobian at q: the smallest one once a row is added that holds its direction.
template <class Model>
SHARED double second_weakest_at(const Model& arm, const Goal<double>& goal, const double (&q)[Model::joints]) {
    Rows<Model::rows, double> J[Model::joints];
    Rows<Model::rows + 1, double> held[Model::joints];
    error_and_jacobian(arm, goal, q, J);
    for (int j = 0; j < Model::joints; ++j) {
        for (int i = 0; i < Model::rows; ++i) held[j][i] = J[j][i];
    }
    const Weakest<Model::joints> weak = weakest(J);
    for (int j = 0; j < Model::joints; ++j) held[j][Model::rows] = weak.direction[j];
    return weakest(held).value;
}

// marks if the Jacobian at q is singular (OTHER where they name no kind), else none.
template <class Model>
STEP int singular_marks(const Model& arm, const Goal<double>& goal, const double (&q)[Model::joints], int marks) {
    if (weakest_at(arm, goal, q).value > arm.tolerances.singular) return 0;
    return marks ? marks : OTHER;
}

// Error to which a candidate must fall that lies a little beyond its family's end.
inline constexpr double DOUBTFUL = 1e-12;

// Whether Newton's method makes a solution of q, a candidate whose margins say that there is none: by what rounding may
// have done to them. q is replaced.
template <class Model>
STEP bool holds(const Model& arm, const Goal<double>& goal, double (&q)[Model::joints], int patience = LONG_PATIENCE) {
    return polish_one<true>(arm, goal, q, {60, CONVERGED, patience}).error <= DOUBTFUL;
}

// How much smaller a second singular value is where two continua cross, or all but do.
inline constexpr double CROSSING = 0.1;

// The column of a full table that q may take, or -1. Of the two singular solutions that lie nearest to each other, most likely
// members of one continuum, that one goes which is less special: whose Jacobian has the larger second singular value. It goes
// for a regular solution, for a singular one that is more special, and for one as special that lies farther from the others.
template <class Model>
PART int less_needed(const Model& arm, const Goal<double>& goal, const Columns<Model::joints>& columns,
                     const double (&q)[Model::joints], int marks) {
    constexpr int N = Model::joints;
    const auto gap_of = [&](const double* a, const double* b) {
        double apart = 0.0;
        for (int j = 0; j < N; ++j) apart = max(apart, abs(gap(arm, j, a[j], b[j])));
        return apart;
    };
    const auto second = [&](const double* row) {
        double x[N];
        for (int j = 0; j < N; ++j) x[j] = row[j];
        return second_weakest_at(arm, goal, x);
    };
    double alone = 1e300, least = 1e300;
    int pair[2] = {-1, -1};
    for (int a = 0; a < columns.many; ++a) {
        if (!(columns.flags[a] & SINGULAR)) continue;
        alone = min(alone, gap_of(columns.row(a), q));
        for (int b = 0; b < a; ++b) {
            if (!(columns.flags[b] & SINGULAR)) continue;
            const double apart = gap_of(columns.row(a), columns.row(b));
            if (apart < least) least = apart, pair[0] = a, pair[1] = b;
        }
    }
    if (pair[0] < 0) return -1;
    const double of_first = second(columns.row(pair[0])), of_other = second(columns.row(pair[1]));
    const int goes = of_first >= of_other ? pair[0] : pair[1];
    if (!marks) return goes;
    const double of_going = max(of_first, of_other), of_new = second(q);
    if (of_new < CROSSING * of_going) return goes;
    return alone > least && of_going >= CROSSING * of_new ? goes : -1;
}

// Store a new solution in column b, in the first free one if that is taken, or in that of one that is less needed.
template <class Model>
PART void add(const Model& arm, const Goal<double>& goal, const Columns<Model::joints>& columns, int b,
              const double (&q)[Model::joints], int marks) {
    if (columns.count() == columns.many) {
        b = less_needed(arm, goal, columns, q, marks);
        if (b < 0) return;
        columns.clear(b);
    }
    keep(columns, b, q, marks);
}

// Fixed numbers in [-1, 1) that look random, so that the same target always has the same answer: the linear congruential
// generator of the C standard's example.
struct Scatter {
    std::uint32_t seed;
    STEP double next() {
        seed = (seed * 1103515245u + 12345u) & 0x7fffffffu;
        return seed / 1073741824.0 - 1.0;
    }
    // The k-th of several sequences.
    static STEP Scatter number(int k) { return {12345u + 7919u * std::uint32_t(k)}; }
};

// Polish the closed form's candidate q of column b on the arm as written, and keep it if it is verified and new.
// near: whether it is near a singularity, so that it is asked for its marks. On an arm that is only near the ideal one a
// candidate there may stand for two solutions, or for none: starts beside it find both, and only what has converged to
// rounding is one, since near a double root an error falls with the square of the distance.
void accept(const Written<6>& arm, const Goal<double>& goal, const double (&q)[6], int b, int marks, bool near,
            const Columns<6>& columns);

// For arms of six joints compiled once, in answer.cpp.
extern template Polished<double> polish_one<true>(const Written<6>&, const Goal<double>&, double (&)[6], const Course&);
extern template Polished<double> polish_one<false>(const Written<6>&, const Goal<double>&, double (&)[6], const Course&);
extern template bool is_new(const Written<6>&, const Goal<double>&, const Columns<6>&, const double (&)[6]);
extern template Weakest<6> weakest_at(const Written<6>&, const Goal<double>&, const double (&)[6]);

}  // namespace urdf_ik::URDF_IK_LEVEL
