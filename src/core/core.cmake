# The sources of the core and the flags that they are compiled with; the paths are relative to this folder. The Python package
# and the library for C++ (CMakeLists.txt beside this) include it.
set(URDF_IK_CORE "${CMAKE_CURRENT_LIST_DIR}")

# The solvers use the vector extensions of GCC and Clang, __builtin_shufflevector among them.
if(NOT CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
  message(FATAL_ERROR "urdf-ik is built by GCC 12, Clang 15 or later; CXX=g++ chooses one, and this is ${CMAKE_CXX_COMPILER_ID}")
elseif(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 12
       OR CMAKE_CXX_COMPILER_ID STREQUAL "Clang" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 15)
  message(FATAL_ERROR "urdf-ik is built by GCC 12, Clang 15 or later; ${CMAKE_CXX_COMPILER} is ${CMAKE_CXX_COMPILER_VERSION}")
endif()

# The instruction sets for which the solvers are compiled. Import chooses the best one that the processor supports.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  set(URDF_IK_LEVELS "v2;v3;v4" CACHE STRING "x86-64 levels to build")
else()
  set(URDF_IK_LEVELS "arm64" CACHE STRING "instruction sets to build")
endif()

# The computations, compiled once for every instruction set.
set(URDF_IK_UNITS
  propose/answer.cpp
  families/inclusion.cpp
  referee/on_curve.cpp
  referee/referee.cpp
  chain.cpp
  families/closed_forms/parallel_shoulder.cpp
  families/closed_forms/reversed.cpp
  families/closed_forms/spherical_middle.cpp
  families/closed_forms/spherical_wrist.cpp
  families/closed_forms/three_parallel.cpp
  families/few_joints/few_joints.cpp
  families/general/elimination.cpp
  families/imperfect/certified.cpp
  families/imperfect/starts.cpp
  families/mimics/coupled.cpp
  families/seven_joints/one_given.cpp
  families/seven_joints/srs.cpp
  inverses.cpp
  level_table.cpp
  motion/path_graph.cpp
  motion/tracker.cpp
  motion/self_motion/on_curve.cpp
)
# Compiled once: solvers made from named values, and the choice of instruction set.
set(URDF_IK_ARMS
  solvers/closed_forms.cpp
  solvers/coupled.cpp
  solvers/elimination.cpp
  solvers/few_joints.cpp
  solvers/one_given.cpp
  solvers/reversed.cpp
  solvers/solver.cpp
  solvers/srs.cpp
  levels.cpp
  processor.cpp
)
# The library for C++ and C: arms from compiled files.
set(URDF_IK_LIBRARY
  library/arm.cpp
  library/c_interface.cpp
  library/json.cpp
  library/json_values.cpp
  library/sha256.cpp
)
# No -ffast-math: solvers rely on NaN and infinities. Fused multiply-add is allowed (contract).
# Nothing that computes throws. GCC moves and fuses other operations where it must reckon with exceptions; without them an arm as
# one file, on a controller too, has the same last digits.
set(URDF_IK_ARITHMETIC -fno-math-errno -ffp-contract=fast -fno-exceptions)
include(CheckCXXCompilerFlag)
# Copies of functions for constant arguments take longer to compile than they save.
foreach(flag -fno-trapping-math -fno-ipa-cp-clone)
  check_cxx_compiler_flag(${flag} HAS${flag})
  if(HAS${flag})
    list(APPEND URDF_IK_ARITHMETIC ${flag})
  endif()
endforeach()
set(URDF_IK_WARNINGS -Wall -Wextra)
if(URDF_IK_WERROR)
  list(APPEND URDF_IK_WARNINGS -Werror)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # GCC's AVX-512 headers use undefined registers on purpose.
  list(APPEND URDF_IK_WARNINGS -Wno-maybe-uninitialized -Wno-uninitialized)
endif()
foreach(list URDF_IK_UNITS URDF_IK_ARMS URDF_IK_LIBRARY)
  list(TRANSFORM ${list} PREPEND "${URDF_IK_CORE}/")
endforeach()

# A rounded sum decides whether an image is inside the limits. It is computed again later, so it must not be fused here.
set_source_files_properties("${URDF_IK_CORE}/library/arm.cpp" PROPERTIES COMPILE_OPTIONS -ffp-contract=off)

# Units that use the same functions are compiled together: each of these is then compiled once.
function(urdf_ik_together group)
  list(TRANSFORM ARGN PREPEND "${URDF_IK_CORE}/")
  set_source_files_properties(${ARGN} PROPERTIES UNITY_GROUP ${group})
endfunction()
urdf_ik_together(certified families/inclusion.cpp referee/on_curve.cpp referee/referee.cpp families/general/elimination.cpp
  families/imperfect/certified.cpp)
urdf_ik_together(shoulder families/closed_forms/parallel_shoulder.cpp families/closed_forms/spherical_middle.cpp)
urdf_ik_together(wrist families/closed_forms/spherical_wrist.cpp families/closed_forms/three_parallel.cpp)
urdf_ik_together(joints families/few_joints/few_joints.cpp families/mimics/coupled.cpp families/seven_joints/srs.cpp
  motion/tracker.cpp)
urdf_ik_together(small propose/answer.cpp chain.cpp families/closed_forms/reversed.cpp families/imperfect/starts.cpp
  families/seven_joints/one_given.cpp inverses.cpp level_table.cpp motion/path_graph.cpp motion/self_motion/on_curve.cpp)

# Set a target's flags for one instruction set, those in URDF_IK_FLAGS among them.
function(urdf_ik_compile_for level target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  target_compile_definitions(${target} PRIVATE URDF_IK_LEVEL=${level})
  target_include_directories(${target} PRIVATE "${URDF_IK_CORE}")
  target_compile_options(${target} PRIVATE ${URDF_IK_WARNINGS} ${URDF_IK_ARITHMETIC} ${URDF_IK_FLAGS})
  if(level MATCHES "^v[0-9]$")
    # Zig's compiler spells the level with underscores.
    check_cxx_compiler_flag(-march=x86-64-${level} HAS_X86_64_${level})
    if(HAS_X86_64_${level})
      target_compile_options(${target} PRIVATE -march=x86-64-${level})
    else()
      target_compile_options(${target} PRIVATE -march=x86_64_${level})
    endif()
  endif()
endfunction()
