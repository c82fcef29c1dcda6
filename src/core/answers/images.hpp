// Images of a joint's value, whole turns away from it, inside its limits; see urdf_ik/solutions/limits.py.
#pragma once

#include <algorithm>
#include <cmath>

namespace urdf_ik {

// A joint's limits, already widened by what they may be exceeded by, and how far its images are apart: 0 where 2 pi more is
// another posture. rad or m.
struct Limit {
    double lower, upper, turn;
    bool one_sided, endless;

    Limit() = default;
    Limit(double low, double high, double apart)
        : lower(low),
          upper(high),
          turn(apart),
          one_sided(!(std::isfinite(low) && std::isfinite(high))),
          endless(apart != 0.0 && std::isinf(low) && std::isinf(high)) {}
};

// Turns to the first and the last image inside; first > last if there is no image.
struct ImageRange {
    double first, last;
    bool empty() const { return !(first <= last); }
    // The turns in the range that are nearest to a number of them.
    double nearest(double turns) const { return std::min(std::max(turns, first), last); }
};

inline ImageRange image_range(double q, const Limit& limit) {
    const double lower = limit.lower, upper = limit.upper, turn = limit.turn;
    if (std::isnan(q)) return {0.0, -1.0};
    if (turn == 0.0) return {0.0, q >= lower && q <= upper ? 0.0 : -1.0};
    double first = std::ceil((lower - q) / turn), last = std::floor((upper - q) / turn);
    // The quotient is rounded; the sum that is returned later decides.
    if (q + (first - 1.0) * turn >= lower) first -= 1.0;
    if (q + first * turn < lower) first += 1.0;
    if (q + (last + 1.0) * turn <= upper) last += 1.0;
    if (q + last * turn > upper) last -= 1.0;
    // Without a limit on a side there is an image for every turn: the one nearest to the value stands for them.
    if (limit.one_sided && first <= last) first = last = std::min(std::max(0.0, first), last);
    return {first, last};
}

// Whether a value has an image inside.
inline bool has_image(double q, const Limit& limit) {
    return (q >= limit.lower && q <= limit.upper) || (limit.turn != 0.0 && !image_range(q, limit).empty());
}

// The image that is fewest turns away; only where there is one.
inline bool nearest_image(double q, const Limit& limit, double& image) {
    image = q;
    if (q >= limit.lower && q <= limit.upper) return true;
    const ImageRange range = image_range(q, limit);
    if (range.empty()) return false;
    image = q + range.nearest(0.0) * limit.turn;
    return true;
}

// The image that is nearest to a reference; only where there is one.
inline bool image_near(double q, double reference, const Limit& limit, double& image) {
    const ImageRange range = image_range(q, limit);
    if (range.empty()) return false;
    const double wanted = limit.turn != 0.0 ? std::nearbyint((reference - q) / limit.turn) : 0.0;
    image = q + (limit.endless ? wanted : range.nearest(wanted)) * limit.turn;
    return true;
}

}  // namespace urdf_ik
