// A 6R arm with a hollow wrist: axes 5 and 6 follow one joint.
#pragma once

#include "families/closed_forms/spherical_wrist_arm.hpp"
#include "families/mimics/coupled_arm.hpp"

namespace urdf_ik {

inline constexpr int MOST_SAMPLES = 512;  // of the wrist's joint

struct HollowWristArm {
    Coupled<6> written;
    Ends ideal;                  // the target as it stands
    SphericalWristArm position;  // axes 1 to 4, as if the wrist's centre were fixed; see `along`
    // Axes 4 and 7 meet in a point that joint 5 may move along both. At samples of joint 5: its value, the cosine of
    // the angle between axes 4 and 7, and the place of the point [m] along axis 4 (beyond the fixed centre) and along
    // axis 7.
    int samples;
    double value[MOST_SAMPLES], cosine[MOST_SAMPLES], along_4[MOST_SAMPLES], along_7[MOST_SAMPLES];
    double flange[3], direction[3];  // a point of axis 7, and where axis 7 points, in the tip
};

}  // namespace urdf_ik
