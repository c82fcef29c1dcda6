// A tracked arm, its state between two cycles, and the result of a cycle.
#pragma once

#include <tuple>

#include "arm/arm.hpp"

namespace urdf_ik {

template <int N> struct TrackedArm {
    Written<N> written;
    double lower[N], upper[N];               // limits [rad, m]; infinite if a joint has none
    double velocity[N], acceleration[N];     // limits [rad/s, rad/s^2, m/s, m/s^2]; infinite if a joint has none
    double dt;                               // length of a cycle [s]
    double recentring;                       // rate at which an arm of seven joints moves away from its limits [1/s]
};

template <int N> struct TrackedState {
    double q[N], v[N];  // positions, angles of any size [rad, m], and velocities in the last cycle [rad/s, m/s]
    double goal[N];     // the last cycle's joint vector before acceleration limits; unused without such limits
    bool exact;         // whether it reaches the last target
};

enum class Tracking : std::uint8_t { ok, limited, held };
enum class Because : std::uint8_t { nothing, velocity, acceleration, limit, reach, singularity, collision };

struct Tracked {
    bool is_pose;  // if false, the target was invalid and the state is unchanged
    Tracking status;
    Because why;
    double distance, angle;                // from the tip to the target, as far as the task controls it [m, rad]
    double distance_before, angle_before;  // the same before the cycle
};

template <int N> using Track = Tracked (*)(const TrackedArm<N>&, TrackedState<N>&, const double* T);
// For one to seven joints.
using TrackerFunctions = std::tuple<Track<1>, Track<2>, Track<3>, Track<4>, Track<5>, Track<6>, Track<7>>;

}  // namespace urdf_ik
