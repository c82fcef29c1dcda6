# find_package(urdf_ik CONFIG) gives
#   urdf_ik::urdf_ik   the library for C++ and C: arms from files
#   urdf_ik_export()   a target with one arm compiled in, made from a URDF when the project is built
#
# With the Python package installed: cmake -Durdf_ik_DIR="$(python -m urdf_ik.cmake)". The library is then a part of the project's
# own build; URDF_IK_LEVELS chooses the instruction sets for which it is compiled.
include_guard(GLOBAL)

get_filename_component(URDF_IK_SOURCES "${CMAKE_CURRENT_LIST_DIR}" DIRECTORY)
if(EXISTS "${CMAKE_CURRENT_LIST_DIR}/urdf_ikTargets.cmake")
  include("${CMAKE_CURRENT_LIST_DIR}/urdf_ikTargets.cmake")
elseif(NOT TARGET urdf_ik::urdf_ik)
  add_subdirectory("${URDF_IK_SOURCES}" "${CMAKE_BINARY_DIR}/urdf_ik" EXCLUDE_FROM_ALL)
endif()

# urdf_ik_export(TARGET arm URDF robot.urdf [BASE link] [TIP link] [NAME name] [C]): a target `arm` with the header <name.hpp>, or
# <name.h> for C. It is made by `urdf-ik export` when the URDF is newer. urdf_ik_PYTHON is the Python that has urdf-ik; default: the
# one that this file was installed with.
function(urdf_ik_export)
  cmake_parse_arguments(ARM "C" "TARGET;URDF;BASE;TIP;NAME" "" ${ARGN})
  if(NOT ARM_TARGET OR NOT ARM_URDF)
    message(FATAL_ERROR "urdf_ik_export needs TARGET and URDF")
  endif()
  if(NOT ARM_NAME)
    set(ARM_NAME ${ARM_TARGET})
  endif()
  if(NOT urdf_ik_PYTHON)
    # PREFIX/lib/pythonX.Y/site-packages/urdf_ik/bundled/core/cmake
    find_program(urdf_ik_PYTHON NAMES python3 python HINTS "${URDF_IK_SOURCES}/../../../../../../bin")
  endif()
  set(folder "${CMAKE_CURRENT_BINARY_DIR}/urdf_ik_arms")
  file(MAKE_DIRECTORY "${folder}")
  set(kind cpp)
  set(ending hpp)
  if(ARM_C)
    set(kind c)
    set(ending h)
  endif()
  set(options)
  foreach(option BASE TIP)
    if(ARM_${option})
      string(TOLOWER ${option} name)
      list(APPEND options --${name} "${ARM_${option}}")
    endif()
  endforeach()
  get_filename_component(urdf "${ARM_URDF}" ABSOLUTE)
  add_custom_command(OUTPUT "${folder}/${ARM_NAME}.${ending}"
    COMMAND "${urdf_ik_PYTHON}" -m urdf_ik.cli export "${urdf}" ${options} --name ${ARM_NAME} --${kind}
            "${folder}/${ARM_NAME}.${ending}"
    DEPENDS "${urdf}" VERBATIM)
  add_custom_target(${ARM_TARGET}_header DEPENDS "${folder}/${ARM_NAME}.${ending}")
  add_library(${ARM_TARGET} INTERFACE)
  add_dependencies(${ARM_TARGET} ${ARM_TARGET}_header)
  target_include_directories(${ARM_TARGET} INTERFACE "${folder}")
  if(NOT ARM_C)
    target_compile_features(${ARM_TARGET} INTERFACE cxx_std_20)
  endif()
  # As the library is compiled: then the answers are the same to the last bit.
  target_compile_options(${ARM_TARGET} INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-ffp-contract=fast;-fno-math-errno;-fno-trapping-math>)
endfunction()
