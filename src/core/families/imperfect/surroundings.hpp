// Regions along valleys (certificate/valley.hpp) whose roots are known, and how a slanted box of joint values lies to one.
#pragma once

#include "certificate/on_surface.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

// A region that holds the roots that were found in it, and no others: within `across` of a piece of a valley, low <= t <= high.
struct Surroundings {
    double q[6], direction[6][6], across, low, high;
    double farthest;  // of each joint from q
    Curve valley;
};

// How a box of joint values q + along u, |u| <= 1, within `rest`, lies to the region.
struct Placed {
    double across, along;  // the farthest point's distance from the valley, and where the box's middle lies along it
    bool inside;
};
STEP Placed placed(const Surroundings& region, const double (&q)[6], const double (&along)[6], const double (&rest)[6]) {
    double d[6], y[5], slope[5], wide[6], moves[6], t = 0.0, sum = 0.0, bend = 0.0;
    for (int j = 0; j < 6; ++j) {
        d[j] = wrap(wrap(q[j] - region.q[j]));
        if (abs(d[j]) > region.farthest) return {__builtin_inf(), __builtin_inf(), false};
    }
    for (int k = 5; k >= 0; --k) {
        double middle = 0.0;
        wide[k] = 1e-14, moves[k] = 0.0;
        for (int j = 0; j < 6; ++j) {
            middle += region.direction[k][j] * d[j], moves[k] += region.direction[k][j] * along[j];
            wide[k] += abs(region.direction[k][j]) * rest[j];
        }
        if (k < 5) {
            // The valley's tangent at t takes the part of its motion.
            sum += square(abs(middle - y[k]) + abs(moves[k] - slope[k] * moves[5]) + wide[k]);
            continue;
        }
        t = middle;
        const double reach = abs(moves[5]) + wide[5], far = abs(t) + reach;
        if (t - reach < region.low || t + reach > region.high) return {__builtin_inf(), t, false};
        region.valley.at(t, y), region.valley.slope_at(t, slope);
        bend = 0.5 * square(moves[5]) * region.valley.bending(far) + wide[5] * region.valley.steepness(far);
    }
    const double across = sqrt(sum) + bend;
    return {across, t, across <= region.across};
}
STEP Placed placed(const Surroundings& region, const double (&q)[6]) { return placed(region, q, {}, {}); }
// The same about a surface, where two ranks are lost: within `across` of it, |t_1| and |t_2| <= along.
struct Patch {
    double q[6], direction[6][6], across, along;
    double farthest;
    Surface surface;

    // The joint values at t.
    PART void at(const double (&t)[2], double (&to)[6]) const {
        double y[4], slope[2][4];
        surface.at(t, y, slope);
        for (int j = 0; j < 6; ++j) {
            double sum = q[j] + t[0] * direction[4][j] + t[1] * direction[5][j];
            for (int k = 0; k < 4; ++k) sum += y[k] * direction[k][j];
            to[j] = wrap(wrap(sum));
        }
    }
    // Whether a box lies in it, and where its middle lies.
    PART bool holds(const double (&joints)[6], const double (&moving)[6], const double (&rest)[6], double (&t)[2]) const {
        double d[6], y[4], slope[2][4], middle[6], wide[6], moves[6], reach[2], sum = 0.0;
        for (int j = 0; j < 6; ++j) {
            d[j] = wrap(wrap(joints[j] - q[j]));
            if (abs(d[j]) > farthest) return false;
        }
        for (int k = 5; k >= 0; --k) {
            middle[k] = moves[k] = 0.0, wide[k] = 1e-14;
            for (int j = 0; j < 6; ++j) {
                middle[k] += direction[k][j] * d[j], moves[k] += direction[k][j] * moving[j];
                wide[k] += abs(direction[k][j]) * rest[j];
            }
            if (k < 4) continue;
            t[k - 4] = middle[k], reach[k - 4] = abs(moves[k]) + wide[k];
            if (abs(middle[k]) + reach[k - 4] > along) return false;
        }
        surface.at(t, y, slope);
        for (int k = 0; k < 4; ++k) {
            sum += square(abs(middle[k] - y[k]) + abs(moves[k] - slope[0][k] * moves[4] - slope[1][k] * moves[5]) + wide[k]);
        }
        const double far = sqrt(square(abs(t[0]) + reach[0]) + square(abs(t[1]) + reach[1]));
        const double moved = square(moves[4]) + square(moves[5]), widths = sqrt(square(wide[4]) + square(wide[5]));
        return sqrt(sum) + 0.5 * moved * surface.bending(far) + widths * surface.steepness(far) <= across;
    }
};
STEP bool holds(const Surroundings& region, const double (&q)[6]) { return placed(region, q).inside; }

}  // namespace urdf_ik::URDF_IK_LEVEL
