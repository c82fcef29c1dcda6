// The instruction set that a source is compiled for. All code that computes is compiled once for each, in a namespace of its own
// (urdf_ik::v2, ::v3, ::v4, ::arm64). Two builds must not share a symbol, or the linker could keep the one that the processor
// cannot run. This rules out functions of the standard library that are not inlined.
#pragma once

#ifndef URDF_IK_LEVEL
#error "URDF_IK_LEVEL names the instruction set of this build: v2, v3, v4 or arm64"
#endif
#define URDF_IK_TEXT_OF(x) #x
#define URDF_IK_TEXT(x) URDF_IK_TEXT_OF(x)

// A step of a solver: always compiled into its caller, so that a block's numbers stay in registers.
#ifdef __wasm__
#define STEP inline
#else
#define STEP inline __attribute__((always_inline))
#endif
// The same for a lambda, after its parameters.
#define IN_PLACE __attribute__((always_inline))
// A part that stays a function call: too large to inline, or rarely needed.
#define PART inline __attribute__((noinline))
// A template that is instantiated in one unit for all others; see answer.cpp.
#define SHARED __attribute__((noinline))
