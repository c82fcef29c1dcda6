// The preparation of arms of six joints for the elimination, compiled once; see ../../preparation.hpp.
#include "families/general/elimination.hpp"

namespace urdf_ik::URDF_IK_LEVEL {

extern const EliminationPreparation elimination_preparation;
const EliminationPreparation elimination_preparation = {try_variants, find_known_poses};

}  // namespace urdf_ik::URDF_IK_LEVEL
