// What the solver of an arm near a family knows of it.
#pragma once

#include "../arm.hpp"

namespace urdf_ik {

template <class FamilyArm> struct ImperfectArm {
    FamilyArm family;   // the ideal arm
    Written<6> written;
    // From frame 1 to the point that is solved for: the arm as written, and the ideal one.
    Written<6> inner, ideal;
    double drift;  // how fast the motion between the two tips changes with the joints, at most [rad, share of size; a rad]
};

}  // namespace urdf_ik
