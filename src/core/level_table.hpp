// What a build for one instruction set offers: the solvers of each unit, by pointer. Plain data.
#pragma once

#include "families/coupled_arm.hpp"
#include "families/one_given_arm.hpp"
#include "families/spherical_wrist_arm.hpp"
#include "families/srs_arm.hpp"
#include "families/three_parallel_arm.hpp"

namespace urdf_ik {

struct LevelTable {
    const char* name;
    const CoupledSolvers* coupled;
    const OneGivenSolvers* one_given;
    const SphericalWristSolvers* spherical_wrist;
    const SrsSolvers* srs;
    const ThreeParallelSolvers* three_parallel;
};

}  // namespace urdf_ik
