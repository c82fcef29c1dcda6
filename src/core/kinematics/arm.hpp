// What the solvers know of an arm: plain numbers with names, the same for every instruction set. No functions here.
// Python prepares them once an arm; the solvers never change them.
#pragma once

#include <cstdint>

namespace urdf_ik {

// Greatest length [m] or angle [rad] that is taken: LARGEST of tolerances.py.
inline constexpr double LARGEST = 1e15;

// See tolerances.py for what each of them means.
struct Tolerances {
    double reach, edge, fold, continuum, singular, duplicate, rotation, exact_rotation, exact_structure;
};

// A rigid motion: rotation by rows, translation [m].
struct Motion {
    double R[3][3], t[3];
};

// What of the tip's pose the joints are to control; arms of six joints and more control all of it.
enum class Task : std::uint8_t { pose, position, position_and_axis, planar_position, planar_pose };

// The arm as the URDF has it, of N joints: step[0], joint 1, step[1], joint 2, ... joint N, step[N], from the base to
// the tip. Each joint turns about its frame's z axis or slides along it (product of exponentials in the frames' own
// axes; Lynch and Park, Modern Robotics, chapter 4, body form joint by joint).
template <int N> struct Written {
    static constexpr int joints = N, rows = 6;  // of the Jacobian
    Motion step[N + 1];
    bool slides[N];
    double size;  // length that tolerances are relative to [m]
    Tolerances tolerances;
    // Of an ideal arm's closed form: whether it is this arm's too, and else whether its candidates near singularities stand for
    // others beside them, or are kept as they are for who follows them.
    bool exact, beside, raw;
    Task task;
    double aimed[3];   // the tip's axis that is aimed, in the tip (Task::position_and_axis, planar_pose)
    double normal[3];  // of the plane, in the base (Task::planar_position, planar_pose)
};

// Where the solver's own frames stand: the first in the base, the last in the tip.
struct Ends {
    double base_rotation[3][3], base_origin[3];  // rotation transposed; origin of frame 1 in the base
    double tool_rotation[3][3], tool_point[3];   // rotation transposed; the point that is solved for, in the tip
};

// The arm in Craig's Denavit-Hartenberg order, as its family wants it to be:
// T = base Rz(t1) Tx(a1) Rx(alpha1) Tz(d2) Rz(t2) ... Rz(t6) tool, with t = q + offset.
struct IdealFrames : Ends {
    double cos_alpha[5], sin_alpha[5], a[5], d[4], offset[6], size;
    double clamp;         // how far below zero a margin may fall before its branch is given up
    double imperfection;  // how far its poses are from those of the arm as written [rad, share of size]; 0: exact
    double signs[3][8];   // of shoulder, elbow and wrist, by branch
};

// One call's poses and answers. q: (m, columns, joints), flags: (m, columns).
struct Batch {
    const double* T;       // (m, 4, 4) row by row
    long m;
    const double* q_ref;   // (joints) near which a continuum is represented; null: zeros
    const double* values;  // (m, parameters) what the targets leave free; null: the defaults
    double* q;
    std::uint8_t* flags;
    // Closed forms of six joints: instead of solutions, the joint vectors of all branches, beyond their ends too, where a
    // margin's root is that of its size. They are not verified, and flags are not set.
    bool beyond = false;
    long whole = 0;        // poses of the call of which these are a part; 0: they are all of it
};
// All solutions of a batch. Returns the index of the first target that is no pose, -1 where all are.
template <class Arm> using SolveArm = long (*)(const Arm&, const Batch&);
// For explanations: the distances [m] that a pose, as seen from the solver's frame 1 (4, 4), asks two axes to have; up to four,
// NaN where there is none.
template <class Arm> using DistancesOf = void (*)(const Arm&, const double* seen, double (&out)[4]);

// Bits of a solution's flags. UNCERTAIN stands in the first column of a pose, whether it is a solution or not: others may be
// missing.
enum Flag : std::uint8_t { VALID = 1, SHOULDER = 2, ELBOW = 4, WRIST = 8, OTHER = 16, UNCERTAIN = 32 };
inline constexpr std::uint8_t SINGULAR = SHOULDER | ELBOW | WRIST | OTHER;

}  // namespace urdf_ik
