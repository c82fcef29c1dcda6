// Images of a joint's value, whole turns away from it, inside its limits; see urdf_ik/ik/solutions/limits.py.
#pragma once

#include <algorithm>
#include <cmath>

namespace urdf_ik {

// A joint's limits, already widened by the tolerance, and the distance of its images: 0 if the joint has only one image.
// rad or m.
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

// Number of turns to the first and to the last image inside; first > last if no image is inside.
struct ImageRange {
    double first, last;
    bool empty() const { return !(first <= last); }
    // The number in the range nearest to `turns`.
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
    // Without a limit on one side there are endlessly many images: the range then holds only the one nearest to the value.
    if (limit.one_sided && first <= last) first = last = std::min(std::max(0.0, first), last);
    return {first, last};
}

// Whether a value has an image inside.
inline bool has_image(double q, const Limit& limit) {
    return (q >= limit.lower && q <= limit.upper) || (limit.turn != 0.0 && !image_range(q, limit).empty());
}

// The image fewest turns away. Returns false if no image is inside.
inline bool nearest_image(double q, const Limit& limit, double& image) {
    image = q;
    if (q >= limit.lower && q <= limit.upper) return true;
    const ImageRange range = image_range(q, limit);
    if (range.empty()) return false;
    image = q + range.nearest(0.0) * limit.turn;
    return true;
}

// The image nearest to a reference. Returns false if no image is inside.
inline bool image_near(double q, double reference, const Limit& limit, double& image) {
    const ImageRange range = image_range(q, limit);
    if (range.empty()) return false;
    const double wanted = limit.turn != 0.0 ? std::nearbyint((reference - q) / limit.turn) : 0.0;
    image = q + (limit.endless ? wanted : range.nearest(wanted)) * limit.turn;
    return true;
}

}  // namespace urdf_ik
