# The version of the sources beside this file; a release with the same minor version is taken. An installation has a file of its own.
file(STRINGS "${CMAKE_CURRENT_LIST_DIR}/../library/urdf_ik.h" PACKAGE_VERSION REGEX "define URDF_IK_VERSION ")
string(REGEX REPLACE ".*\"(.*)\".*" "\\1" PACKAGE_VERSION "${PACKAGE_VERSION}")
string(REGEX MATCH "^[0-9]+\\.[0-9]+" minor "${PACKAGE_VERSION}")
string(REGEX MATCH "^[0-9]+\\.[0-9]+" wanted "${PACKAGE_FIND_VERSION}")
if(minor STREQUAL wanted AND NOT PACKAGE_FIND_VERSION VERSION_GREATER PACKAGE_VERSION)
  set(PACKAGE_VERSION_COMPATIBLE TRUE)
endif()
