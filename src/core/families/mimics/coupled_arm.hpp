// Arms whose joints drive several axes each, as the URDF has them. The joints are scaled: x is in rad, or in shares of the
// arm's size for one that slides.
#pragma once

#include "kinematics/arm.hpp"

namespace urdf_ik {

inline constexpr int MOST_AXES = 12;
// Columns of a pose, at most.
inline constexpr int MOST_COLUMNS = 96;

template <int N> struct Coupled {
    static constexpr int joints = N;
    int axes;
    Motion step[MOST_AXES + 1];  // as in Written
    bool slides[MOST_AXES];
    double gain[MOST_AXES][N];  // of an axis [rad, m] by a scaled joint
    double unit[N], period[N];  // of a scaled joint: what 1 is [rad, m]; after which it repeats, 0: never
    double size;
    Tolerances tolerances;
};

template <int N> struct CoupledArm {
    Coupled<N> written;
    double middle[N], half[N];        // of where the scaled joints are looked for
    double rates[MOST_AXES][N];       // greatest rates [rad] at which the joints turn what is behind each axis
    int columns;
};

// Boxes of one level of the search at most; what it needs of memory, in boxes.
inline constexpr long BOXES = 60000, SCRATCH = 2 * BOXES;

struct HollowWristArm;
template <int N> using SolveCoupled = long (*)(const CoupledArm<N>&, const Batch&, double* scratch);
struct CoupledSolvers {
    SolveCoupled<1> one;
    SolveCoupled<2> two;
    SolveCoupled<3> three;
    SolveCoupled<4> four;
    long (*hollow_wrist)(const HollowWristArm&, const Batch&);
    template <int N> SolveCoupled<N> solve() const {
        if constexpr (N == 1) return one;
        else if constexpr (N == 2) return two;
        else if constexpr (N == 3) return three;
        else return four;
    }
};

}  // namespace urdf_ik
