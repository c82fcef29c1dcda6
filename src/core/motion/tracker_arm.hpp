// A tracked arm, its state between two cycles, and the result of a cycle.
#pragma once

#include "kinematics/arm.hpp"

namespace urdf_ik {

template <int N> struct TrackedArm {
    Written<N> written;
    double lower[N], upper[N];               // limits [rad, m]; infinite where there is none
    double velocity[N], acceleration[N];     // greatest [rad/s, m/s and so on]; infinite where there is none
    double dt;                               // of a cycle [s]
    double recentring;                       // rate at which seven joints move away from their limits [1/s]
};

template <int N> struct TrackedState {
    double q[N], v[N];  // where the joints are, angles of any size, and how fast they got there [rad/s, m/s]
    double goal[N];     // where the last target would have had them (with limits on the acceleration),
    bool exact;         // and whether that was exact
};

enum class Tracking : std::uint8_t { ok, limited, held };
enum class Because : std::uint8_t { nothing, velocity, acceleration, limit, reach, singularity, collision };

struct Tracked {
    bool is_pose;  // else nothing has happened
    Tracking status;
    Because why;
    double distance, angle;                // from the tip to what the task asks for [m, rad]
    double distance_before, angle_before;  // the same before the cycle
};

template <int N> using Track = Tracked (*)(const TrackedArm<N>&, TrackedState<N>&, const double* T);
struct TrackerFunctions {
    Track<1> one;
    Track<2> two;
    Track<3> three;
    Track<4> four;
    Track<5> five;
    Track<6> six;
    Track<7> seven;
    template <int N> Track<N> of() const {
        if constexpr (N == 1) return one;
        else if constexpr (N == 2) return two;
        else if constexpr (N == 3) return three;
        else if constexpr (N == 4) return four;
        else if constexpr (N == 5) return five;
        else if constexpr (N == 6) return six;
        else return seven;
    }
};

}  // namespace urdf_ik
