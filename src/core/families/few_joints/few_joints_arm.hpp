// Arms with one to five joints, and arms of six joints with slides.
#pragma once

#include "arm/arm.hpp"

namespace urdf_ik {

// Three joints that place a point, at joint values of zero. Lengths are shares of the arm's size.
struct PositionStep {
    bool slides[3];
    double direction[3][3], point[3][3];  // of each axis; the points of axes 1 and 2 are the feet of their common normal
    double X[3];
};

// A way to solve for few joints: a position step, and up to two turns behind it that leave its point in place.
struct FewJointsWay {
    PositionStep step;
    bool reversed;        // whether this solves the chain from tip to base
    int turns;            // number of turns behind the step
    double axis[2][3];    // axes of these turns
    int joint[5];         // the index in the arm of each joint of step and turns; -1: an added joint that has to stay at zero
    double home[3][3];    // the tip's rotation at zero
    double in_tip[3];     // the step's point in the tip [share of size]
};

template <int N> struct FewJointsArm {
    Written<N> written;
    int ways;  // the second one is used if the first one leaves a joint nearly free
    FewJointsWay way[2];
};

// Two or three parallel turning joints and at most one slide along them.
template <int N> struct PlanarArm : FewJointsArm<N> {
    Ends ideal;               // the plane's frame on axis 1, as high as the end of the links at zero
    double link[2], angle[2]; // lengths [m], and directions in the plane at zero [rad]
    double bend;              // the difference of the directions [rad]
    double sign[4];           // of joints 1, 2, 3 and the slide, against the plane's normal
    int joint[4];             // the index of each in the arm; -1: the arm lacks it
};

// Six joints with slides. Three turning joints make the orientation; the others are a position step or three slides.
struct SlidesArm {
    Written<6> written;
    bool by_wrist;            // the last three axes meet; else three slides
    PositionStep step;        // by_wrist: the first three joints, and the point where the other axes meet
    double in_tip[3];         // that point in the tip [share of size]
    int turn[3];              // the joints that make the orientation
    double first[3][3], last[3][3];  // frames on the first and the last of them at zero, rotations by rows
    double ca, sa, cb, sb;    // cosine and sine of the angles between them
    double bend;              // of the middle one at zero [rad]
    double home[3][3];        // the tip's rotation at zero
    double clamp;             // how far below zero a margin may fall before its branch is given up
    double imperfection;      // how far the wrist is from meeting in a point [share of size]; 0: exact
};

// Six joints that are singular everywhere.
struct SampledArm {
    Written<6> written;
};

// Seven joints with one held.
struct SampledHeldArm {
    Written<7> written;
    int held;
    double value;  // the default [rad, m]
};

// Five joints, solved as an arm of six with a joint added in front or behind.
struct CompletedArm {
    Written<5> written;
    int at;       // the index among the six of the arm's first joint
    int columns;  // columns of a pose
};

// Solutions of the arm of six: q (m, columns, 6), flags (m, columns).
struct OfSix {
    const double* q;
    const std::uint8_t* flags;
    int columns;
};

struct FewJointsSolvers {
    SolveArm<FewJointsArm<1>> one;
    SolveArm<FewJointsArm<2>> two;
    SolveArm<FewJointsArm<3>> three, three_in_plane;  // four columns, and two
    SolveArm<FewJointsArm<4>> four;
    SolveArm<FewJointsArm<5>> five;
    SolveArm<PlanarArm<2>> planar_2, planar_points;
    SolveArm<PlanarArm<3>> planar_3;
    SolveArm<PlanarArm<4>> planar_4;
    SolveArm<SlidesArm> slides_2, slides_4, slides_8;  // by the number of columns
    SolveArm<SampledArm> sampled;
    SolveArm<SampledHeldArm> sampled_held;
    void (*completed)(const CompletedArm&, const Batch&, const OfSix&);
};

}  // namespace urdf_ik
