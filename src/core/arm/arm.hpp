// An arm's numbers for the solvers: plain data, the same for every instruction set. They are prepared once per arm, and the
// solvers never change them.
#pragma once

#include <cstdint>

namespace urdf_ik {

// Greatest length [m] or angle [rad] that is accepted: LARGEST of tolerances.py.
inline constexpr double LARGEST = 1e15;

// Documented in tolerances.py.
struct Tolerances {
    double reach, edge, fold, continuum, singular, duplicate, rotation, exact_rotation, exact_structure;
};

// A rigid motion: rotation by rows, translation [m].
struct Motion {
    double R[3][3], t[3];
};

// The part of the tip's pose that the joints control; arms with six joints or more control all of it.
enum class Task : std::uint8_t { pose, position, position_and_axis, planar_position, planar_pose };

// The arm as the URDF has it, of N joints: step[0], joint 1, step[1], joint 2, ... joint N, step[N], from the base to
// the tip. Each joint turns about its frame's z axis or slides along it (product of exponentials in the frames' own
// axes; Lynch and Park, Modern Robotics, chapter 4, body form joint by joint).
template <int N> struct Written {
    static constexpr int joints = N, rows = 6;  // rows of the Jacobian
    Motion step[N + 1];
    bool slides[N];
    double size;  // reference length of the tolerances [m]
    Tolerances tolerances;
    bool exact;  // whether the closed form holds for this arm exactly
    Task task;
    double aimed[3];   // the aimed axis, in the tip (Task::position_and_axis, planar_pose)
    double normal[3];  // of the plane, in the base (Task::planar_position, planar_pose)
};

// The solver's own frames: the first one in the base, the last one in the tip.
struct Ends {
    double base_rotation[3][3], base_origin[3];  // rotation transposed; origin of frame 1 in the base
    double tool_rotation[3][3], tool_point[3];   // rotation transposed; the solved point, in the tip
};

// Bounds on the motion between the tips of two arms at the same joint vector. Entry k: by the steps from k on, which joint k moves;
// entry 0: by all. turn [rad]; shift [m]; length: of the steps [m]. Derived in ik/families/parts/ideal.py.
struct Displacement {
    double turn[7], shift[7], length[7];
};

// The nearest arm that has its family's structure exactly, by Craig's Denavit-Hartenberg parameters:
// T = base Rz(t1) Tx(a1) Rx(alpha1) Tz(d2) Rz(t2) ... Rz(t6) tool, with t = q + offset.
struct IdealFrames : Ends {
    double cos_alpha[5], sin_alpha[5], a[5], d[4], offset[6], size;
    double imperfection;  // distance of its poses from those of the arm as written [rad, share of size]; 0: exact
    double signs[3][8];   // of shoulder, elbow and wrist, by branch
    double together;      // see Clear in propose/branch.hpp
    Displacement displacement;  // from the arm as written
};

// One call's poses and answers. q: (m, columns, joints), flags: (m, columns).
struct Batch {
    const double* T;       // (m, 4, 4) row by row
    long m;
    const double* q_ref;   // (joints) free joints of a continuum take values near these; null: zeros
    const double* values;  // (m, parameters) redundancy parameters; null: the defaults
    double* q;
    std::uint8_t* flags;
    // Closed forms of six joints: return the joint vectors of all branches instead of solutions, also beyond a branch's end, where
    // the root of a margin is that of its absolute value. They are not verified, and flags are not set.
    bool beyond = false;
    long whole = 0;        // number of poses in the whole call if this batch is a part of it, else 0
};
// All solutions of a batch. Returns the index of the first invalid pose, or -1.
template <class Arm> using SolveArm = long (*)(const Arm&, const Batch&);

// Bits of a solution's flags. UNCERTAIN is a part of the pose's status, in its first column: see certify/status.hpp.
enum Flag : std::uint8_t { VALID = 1, SHOULDER = 2, ELBOW = 4, WRIST = 8, OTHER = 16, UNCERTAIN = 32 };
inline constexpr std::uint8_t SINGULAR = SHOULDER | ELBOW | WRIST | OTHER;

}  // namespace urdf_ik
