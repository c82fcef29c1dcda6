// The tracker, compiled once for every instruction set; see tracker.hpp.
#include "motion/tracker.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

extern const TrackerFunctions tracker_functions = {track<1>, track<2>, track<3>, track<4>, track<5>, track<6>, track<7>};

}  // namespace urdf_ik::URDF_IK_LEVEL
