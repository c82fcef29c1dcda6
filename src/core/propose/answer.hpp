// The solutions of one pose: deciding whether a candidate is new, keeping it in a column, sorting the columns.
#pragma once

#include "certify/status.hpp"
#include "numbers/scatter.hpp"
#include "propose/polish.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// The columns of one pose in the caller's memory: q (many, N), flags (many).
template <int N> struct Columns {
    double* q;
    std::uint8_t* flags;
    int many;

    STEP double (&row(int b) const)[N] { return *reinterpret_cast<double (*)[N]>(q + N * b); }
    STEP bool valid(int b) const { return flags[b] & VALID; }
    STEP int count() const {
        int n = 0;
        for (int b = 0; b < many; ++b) n += valid(b);
        return n;
    }
    // The first free column, -1 if there is none.
    STEP int vacant() const {
        for (int b = 0; b < many; ++b) {
            if (!valid(b)) return b;
        }
        return -1;
    }
    STEP void swap(int a, int b) const {
        for (int j = 0; j < N; ++j) exchange(row(a)[j], row(b)[j]);
        exchange(flags[a], flags[b]);
    }
    STEP void clear(int b) const {
        for (int j = 0; j < N; ++j) row(b)[j] = __builtin_nan("");
        flags[b] = 0;
    }
    STEP void clear() const {
        for (int b = 0; b < many; ++b) clear(b);
    }
};

// The reference: on a continuum of solutions, free joints take values near it. It is the caller's joint vector, or zeros.
template <int N> struct Reference {
    double q[N];
    double given;  // 1 if the caller gave it, else 0
};
template <int N> STEP Reference<N> reference_of(const double* q_ref) {
    Reference<N> r;
    for (int j = 0; j < N; ++j) r.q[j] = q_ref ? q_ref[j] : 0.0;
    r.given = q_ref ? 1.0 : 0.0;
    return r;
}

// The error at q.
template <class Model> SHARED double missed_by(const Model& arm, const Goal<double>& goal, const double (&q)[Model::joints]) {
    return error_at(arm, goal, q).size;
}

// The smallest singular value of the Jacobian at q, and its direction.
template <class Model>
SHARED Weakest<Model::joints> weakest_at(const Model& arm, const Goal<double>& goal, const double (&q)[Model::joints]) {
    Rows<Model::rows, double> J[Model::joints];
    derivatives_at(arm, goal, q, J);
    return weakest(J);
}

// The greatest difference of two joint vectors in a joint [rad, share of size], the shorter way round.
template <class Model> STEP double distance(const Model& arm, const double* a, const double* b) {
    double most = 0.0;
    for (int j = 0; j < Model::joints; ++j) most = max(most, abs(gap(arm, j, a[j], b[j])));
    return most;
}

STEP MaskOf<Block> mask_of(unsigned lanes) {
    double x[BLOCK];
    for (int l = 0; l < BLOCK; ++l) x[l] = lanes >> l & 1;
    return load<Block>(x) > Block(0.0);
}
// The solutions in a block of columns from `from` on, zeros where there is none. Returns a bit for each lane with a solution.
template <int N> STEP unsigned solutions_in(const Columns<N>& columns, int from, Block (&q)[N]) {
    unsigned lanes = 0;
    for (Block& each : q) each = 0.0;
    for (int l = 0; l < BLOCK && from + l < columns.many; ++l) {
        if (!columns.valid(from + l)) continue;
        lanes |= 1u << l;
        for (int j = 0; j < N; ++j) q[j].set(l, columns.row(from + l)[j]);
    }
    return lanes;
}

// The column nearest to a joint vector; -1 if all are free.
template <class Model> STEP int nearest_column(const Model& arm, const Columns<Model::joints>& columns, const double* q) {
    int nearest = -1;
    double least = __builtin_inf();
    for (int b = 0; b < columns.many; ++b) {
        if (!columns.valid(b)) continue;
        const double apart = distance(arm, q, columns.row(b));
        if (apart < least) least = apart, nearest = b;
    }
    return nearest;
}

// Whether q differs from every solution in the columns. Two vectors are one double root if the arm is in the pose, to rounding,
// at their midpoint too. They are one inaccurate root if their distance is at most their errors over the Jacobians' smallest
// singular values.
template <class Model>
SHARED bool is_new(const Model& arm, const Goal<double>& goal, const Columns<Model::joints>& columns,
                   const double (&q)[Model::joints]) {
    constexpr int N = Model::joints;
    // The pose of a slide many sizes out has a rounding error in proportion to that distance.
    double far = 1.0;
    for (int j = 0; j < N; ++j) far = max(far, abs(gap(arm, j, q[j], 0.0)) / PI);
    const double same = arm.tolerances.duplicate * far;
    for (int b = 0; b < columns.many; ++b) {
        if (!columns.valid(b)) continue;
        const double (&other)[N] = columns.row(b);
        double apart = 0.0, middle[N];
        for (int j = 0; j < N && (apart < NEAR || apart <= same); ++j) {
            const double step = gap(arm, j, q[j], other[j]);
            middle[j] = advanced(arm, j, other[j], 0.5 * step);
            apart = max(apart, abs(step));
        }
        if (apart <= same) return false;
        if (apart >= NEAR) continue;
        if (missed_by(arm, goal, middle) <= arm.tolerances.fold * far) return false;
        const double left = missed_by(arm, goal, q) + missed_by(arm, goal, other);
        const auto is_known_to = [&](const double (&x)[N]) { return apart * weakest_at(arm, goal, x).value <= left; };
        if (left > FINISHED && is_known_to(q) && is_known_to(other)) return false;
    }
    return true;
}

// Store q in column b, or in the first free column if b is taken. If all are taken, q is dropped.
template <int N> STEP void keep(const Columns<N>& columns, int b, const double (&q)[N], int marks) {
    if (columns.valid(b)) b = columns.vacant();
    if (b < 0) return;
    for (int j = 0; j < N; ++j) columns.row(b)[j] = q[j];
    columns.flags[b] = std::uint8_t(VALID | marks);
}

// Sort the solutions by their joint values, the first joint first; invalid columns come last. If an arm's branches have no names,
// the order of its columns then does not depend on the order in which solutions were found, and not on rounding.
template <int N> PART void sort(const Columns<N>& columns) {
    const auto before = [&](int a, int b) {
        if (columns.valid(a) != columns.valid(b)) return columns.valid(a);
        if (!columns.valid(a)) return false;
        for (int j = 0; j < N; ++j) {
            if (abs(columns.row(a)[j] - columns.row(b)[j]) > SAME) return columns.row(a)[j] < columns.row(b)[j];
        }
        return false;
    };
    for (int i = 1; i < columns.many; ++i) {
        for (int k = i; k > 0 && before(k, k - 1); --k) columns.swap(k, k - 1);
    }
}

// Joint vectors all over the joint space, one in each lane.
template <int N> STEP void scatter_over(const Written<N>& arm, Scatter& scatter, Block (&q)[N]) {
    for (int l = 0; l < BLOCK; ++l) {
        for (int j = 0; j < N; ++j) q[j].set(l, scatter.next() * (arm.slides[j] ? arm.size : PI));
    }
}

// The flags of a singular solution: `marks`, or OTHER if that is 0; 0 if the Jacobian's smallest singular value makes it regular.
STEP int singular_marks(const Tolerances& tolerances, double least, int marks) {
    if (least > tolerances.singular) return 0;
    return marks ? marks : OTHER;
}
template <class Model>
STEP int singular_marks(const Model& arm, const Goal<double>& goal, const double (&q)[Model::joints], int marks) {
    return singular_marks(arm.tolerances, weakest_at(arm, goal, q).value, marks);
}

// Whether Newton's method from the midpoint of two singular solutions stays near it, and ends at a singular solution too.
template <class Model>
PART bool has_member_between(const Model& arm, const Goal<double>& goal, const double (&q)[Model::joints], const double* other) {
    constexpr int N = Model::joints;
    double middle[N];
    for (int j = 0; j < N; ++j) middle[j] = advanced(arm, j, other[j], 0.5 * gap(arm, j, q[j], other[j]));
    if (polish_one<true>(arm, goal, middle, {30, CONVERGED, LONG_PATIENCE}).error > VANISHING) return false;
    const double nearer = min(distance(arm, middle, q), distance(arm, middle, other));
    return nearer > 0.25 * distance(arm, q, other) && weakest_at(arm, goal, middle).value <= arm.tolerances.singular;
}

// Moves q by a step along a direction, and from there back to the pose. Returns the error.
template <class Model>
STEP double move_along(const Model& arm, const Goal<double>& goal, const Course& back, double step,
                       const double (&direction)[Model::joints], double (&q)[Model::joints]) {
    for (int j = 0; j < Model::joints; ++j) q[j] = advanced(arm, j, q[j], step * direction[j]);
    return polish_one<true>(arm, goal, q, back).error;
}

// Steps along a continuum [rad, share of size], and their greatest number: more than a loop of three turning joints needs.
inline constexpr double STRIDE = 0.2;
inline constexpr int STRIDES = 100;

// Whether two singular solutions lie on one continuum: there is a member between them, or steps along it from one come to the
// other.
template <class Model> PART bool is_joined(const Model& arm, const Goal<double>& goal, const double (&q)[Model::joints],
                                           const double* other) {
    constexpr int N = Model::joints;
    if (has_member_between(arm, goal, q, other)) return true;
    double at[N], heading[N];
    for (int j = 0; j < N; ++j) at[j] = q[j], heading[j] = gap(arm, j, other[j], q[j]);
    for (int step = 0; step < STRIDES && distance(arm, at, other) > STRIDE; ++step) {
        const Weakest<N> weak = weakest_at(arm, goal, at);
        double forward = 0.0;
        for (int j = 0; j < N; ++j) forward += weak.direction[j] * heading[j];
        for (int j = 0; j < N; ++j) heading[j] = copysign(1.0, forward) * weak.direction[j];
        if (weak.value > arm.tolerances.singular || move_along(arm, goal, ACROSS_A_VALLEY, STRIDE, heading, at) > VANISHING)
            return false;
    }
    return distance(arm, at, other) <= STRIDE && has_member_between(arm, goal, at, other);
}

// For arms of six joints compiled once, in answer.cpp.
extern template Polished<Block> polish_block<true>(const Written<6>&, const Goal<Block>&, Block (&)[6], const Course&,
                                                   const MaskOf<Block>&);
extern template Polished<Block> polish_block<false>(const Written<6>&, const Goal<Block>&, Block (&)[6], const Course&,
                                                    const MaskOf<Block>&);
extern template Polished<double> polish_one<true>(const Written<6>&, const Goal<double>&, double (&)[6], const Course&);
extern template Error<double> derivatives_at(const Written<6>&, const Goal<double>&, const double (&)[6], Rows<6, double> (&)[6]);
extern template double missed_by(const Written<6>&, const Goal<double>&, const double (&)[6]);
extern template bool is_new(const Written<6>&, const Goal<double>&, const Columns<6>&, const double (&)[6]);
extern template Weakest<6> weakest_at(const Written<6>&, const Goal<double>&, const double (&)[6]);

}  // namespace urdf_ik::URDF_IK_LEVEL
