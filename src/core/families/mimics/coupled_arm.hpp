// Arms whose joints drive several axes each, as in the URDF. The joints are scaled: x is in rad, or in shares of the
// arm's size for a slide.
#pragma once

#include "arm/arm.hpp"

namespace urdf_ik {

inline constexpr int MOST_AXES = 12;
// Most columns of a pose.
inline constexpr int MOST_COLUMNS = 96;

template <int N> struct Coupled {
    static constexpr int joints = N;
    int axes;
    Motion step[MOST_AXES + 1];  // as in Written
    bool slides[MOST_AXES];
    double gain[MOST_AXES][N];  // change of an axis [rad, m] per unit of a scaled joint
    double unit[N], period[N];  // of a scaled joint: the value of one unit [rad, m]; its period in units, 0 if it has none
    double size;
    Tolerances tolerances;
};

template <int N> struct CoupledArm {
    Coupled<N> written;
    double middle[N], half[N];        // of the box in which the scaled joints are searched
    double rates[MOST_AXES][N];       // greatest rate [rad per unit] at which each joint turns the links behind an axis
    int columns;
};

// Most boxes on one level of the search; its scratch memory, in boxes.
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
