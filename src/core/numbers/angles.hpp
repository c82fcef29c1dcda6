// Angles, for every instruction set and for code of none.
#pragma once

namespace urdf_ik {

inline constexpr double PI = 3.141592653589793;

// The angle a in (-pi, pi], for any a. An angle inside is unchanged.
inline __attribute__((always_inline)) double principal_angle(double a) {
    if (__builtin_fabs(a) < PI) return a;
    const double rest = __builtin_remainder(a, 2.0 * PI);
    return rest <= -PI ? PI : rest;
}

// A joint's or a redundancy parameter's value: an angle in (-pi, pi] if it turns.
inline __attribute__((always_inline)) double principal_value(double value, bool turns) {
    return turns ? principal_angle(value) : value;
}

}  // namespace urdf_ik
