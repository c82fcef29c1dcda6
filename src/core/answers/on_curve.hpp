// Whether a singular solution lies on a curve of solutions.
#pragma once

#include "answers/answer.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// Steps along a curve of solutions [rad], to either side.
inline constexpr double ALONG_CURVE = 0.02;
inline constexpr int STEPS_ALONG_CURVE = 3;

// Newton's method there, without motion along the valley.
inline constexpr Course HELD_ON_CURVE = {8, FINISHED, LONG_PATIENCE, HELD};

// Whether a singular solution lies on a curve of solutions: Newton's method from points along the weakest direction, each farther
// away, ends beside them, and keeps the pose to the tolerance of solutions.
PART bool is_on_curve(const Written<6>& arm, const Goal<double>& goal, const double (&q)[6]) {
    const Weakest<6> weak = weakest_at(arm, goal, q);
    if (weak.value > arm.tolerances.singular) return false;
    for (int k = 1; k <= STEPS_ALONG_CURVE; ++k) {
        for (int sign = -1; sign <= 1; sign += 2) {
            double at[6], away = 0.0;
            for (int j = 0; j < 6; ++j) at[j] = wrap(q[j] + sign * k * ALONG_CURVE * weak.direction[j]);
            if (!(polish_one<true>(arm, goal, at, HELD_ON_CURVE).error <= arm.tolerances.reach)) return false;
            for (int j = 0; j < 6; ++j) away += sign * weak.direction[j] * wrap(at[j] - q[j]);
            if (!(away > 0.7 * k * ALONG_CURVE && away < 1.3 * k * ALONG_CURVE)) return false;
        }
    }
    return true;
}

// Whether a solution in the columns does.
PART bool keep_curve(const Written<6>& arm, const Goal<double>& goal, const Columns<6>& columns) {
    for (int b = 0; b < columns.many; ++b) {
        if (!columns.valid(b)) continue;
        double q[6];
        for (int j = 0; j < 6; ++j) q[j] = columns.row(b)[j];
        if (is_on_curve(arm, goal, q)) return true;
    }
    return false;
}

}  // namespace urdf_ik::URDF_IK_LEVEL
