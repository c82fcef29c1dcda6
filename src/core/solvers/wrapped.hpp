// Solving with the solver of another arm, part by part so that targets and solutions stay in the cache. `inner` is a function of a
// Batch, as Solver::solve is; `steps` holds the functions of the instruction set.
#pragma once

#include "arm/arm.hpp"
#include "families/few_joints/few_joints_arm.hpp"
#include "families/seven_joints/one_given_arm.hpp"

namespace urdf_ik {

// How large the other arm's answers are.
struct Inner {
    int joints, branches, parameters;
};

// ---- the chain from tip to base ------------------------------------------------------------------------------------------------

// Poses per part: their solutions stay in the nearest cache until they are reversed. A multiple of every block's lanes, so that the
// same instructions solve a pose wherever it is in the batch.
inline constexpr long REVERSED_AT_ONCE = 32;
inline constexpr int MOST_REVERSED_JOINTS = 8;

template <class Solve, class Steps>
long solve_reversed(const Inner& of, const Solve& inner, const Steps& steps, const Batch& batch) {
    double T[16 * REVERSED_AT_ONCE], reference[MOST_REVERSED_JOINTS];
    Batch part = batch;
    part.T = T, part.whole = 0;
    if (batch.q_ref) {
        for (int j = 0; j < of.joints; ++j) reference[j] = batch.q_ref[of.joints - 1 - j];
        part.q_ref = reference;
    }
    for (long start = 0; start < batch.m; start += REVERSED_AT_ONCE) {
        part.m = batch.m - start < REVERSED_AT_ONCE ? batch.m - start : REVERSED_AT_ONCE;
        part.q = batch.q + start * of.branches * of.joints, part.flags = batch.flags + start * of.branches;
        part.values = batch.values ? batch.values + of.parameters * start : nullptr;
        steps.invert_poses(batch.T + 16 * start, part.m, T);
        const long bad = inner(part);
        if (bad >= 0) return start + bad;
        steps.turn_round(part.m * of.branches, of.joints, part.q, part.flags);
    }
    return -1;
}

// ---- five joints, completed to six ---------------------------------------------------------------------------------------------

inline constexpr long COMPLETED_AT_ONCE = 32;
inline constexpr int MOST_COLUMNS_OF_SIX = 32;

template <class Solve, class Steps>
long solve_completed(const CompletedArm& arm, const Inner& six, const Solve& inner, const Steps& steps, const Batch& batch) {
    double q_ref[6] = {}, q[COMPLETED_AT_ONCE * MOST_COLUMNS_OF_SIX * 6];
    std::uint8_t flags[COMPLETED_AT_ONCE * MOST_COLUMNS_OF_SIX];
    for (int k = 0; batch.q_ref && k < 5; ++k) q_ref[arm.at + k] = batch.q_ref[k];
    for (long start = 0; start < batch.m; start += COMPLETED_AT_ONCE) {
        const long many = batch.m - start < COMPLETED_AT_ONCE ? batch.m - start : COMPLETED_AT_ONCE;
        Batch part = {batch.T + 16 * start, many, batch.q_ref ? q_ref : nullptr, nullptr, q, flags};
        const long bad = inner(part);
        if (bad >= 0) return start + bad;
        part.q = batch.q + 5 * arm.columns * start, part.flags = batch.flags + arm.columns * start, part.q_ref = batch.q_ref;
        steps.completed(arm, part, {q, flags, six.branches});
    }
    return -1;
}

// ---- one joint given, or a rotation about an axis of the tip --------------------------------------------------------------------

inline constexpr int MOST_JOINTS_BESIDE = 9, MOST_PARAMETERS = 4;

// The given joint's place among all joints.
inline int place_of(const GivenJoint& given, const Inner& others) {
    return given.last ? others.joints : given.before < 0 ? 0 : given.before;
}
// A joint vector without the given joint, if its value is part of the joint vector.
inline void without_given(const GivenJoint& given, bool inserted, const Inner& others, const double* q, double* rest) {
    const int skipped = inserted ? place_of(given, others) : others.joints;
    for (int j = 0; j < others.joints; ++j) rest[j] = q[j + (j >= skipped)];
}

// inserted: whether the value is a joint's and is inserted into the joint vectors. most, rows: greatest number of poses and of
// joint vectors in a part; rows is at least the number of branches.
template <int most, int rows, class Solve, class Steps>
long solve_one_given(const GivenJoint& given, bool inserted, const Inner& others, const Solve& inner, const Steps& steps,
                     const Batch& batch) {
    if (!inserted && !batch.values) return inner(batch);
    const int parameters = others.parameters + 1, joints = others.joints + inserted, branches = others.branches;
    double T[16 * (most + MOST_LANES)], values[most], rest[most * MOST_PARAMETERS], q[MOST_JOINTS_BESIDE * rows];
    double near[MOST_JOINTS_BESIDE];
    if (batch.q_ref) without_given(given, inserted, others, batch.q_ref, near);
    const long at_once = rows / branches < most ? rows / branches : most;
    for (long start = 0; start < batch.m; start += at_once) {
        Batch part = batch;
        part.m = batch.m - start < at_once ? batch.m - start : at_once;
        part.T += 16 * start, part.flags += branches * start, part.q += long(joints) * branches * start;
        if (part.values) {
            const double* from = batch.values + parameters * start;
            for (long i = 0; i < part.m; ++i, from += parameters) {
                values[i] = from[0];
                for (int k = 1; k < parameters; ++k) rest[(parameters - 1) * i + k - 1] = from[k];
            }
            part.values = values;
        }
        steps.move(given, part, T, values);
        const double* reference = part.q_ref ? near : nullptr;
        const double* theirs = batch.values && others.parameters ? rest : nullptr;
        const long bad = inner({T, part.m, reference, theirs, inserted ? q : part.q, part.flags, batch.beyond});
        if (bad >= 0) return start + bad;
        if (inserted) steps.insert(given, part, q, values, others.joints, branches);
    }
    return -1;
}

}  // namespace urdf_ik
