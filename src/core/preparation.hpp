// The functions that prepare an arm: its numbers must not depend on the processor. They are compiled once, in the namespace plain,
// without fused multiply-add and for no more than every processor has.
#pragma once

#include "chain_arm.hpp"
#include "families/general/elimination_arm.hpp"

namespace urdf_ik::plain {

extern const ChainFunctions chain_functions;
extern const EliminationPreparation elimination_preparation;

}  // namespace urdf_ik::plain
