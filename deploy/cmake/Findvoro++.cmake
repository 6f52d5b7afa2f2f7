# SPDX-License-Identifier: Apache-2.0
# Finds voro++, which installs neither a CMake nor a pkg-config file. Defines voro++::voro++.
find_path(VOROPP_INCLUDE_DIR voro++/voro++.hh)
find_library(VOROPP_LIBRARY voro++)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(voro++ REQUIRED_VARS VOROPP_LIBRARY VOROPP_INCLUDE_DIR)
if(voro++_FOUND AND NOT TARGET voro++::voro++)
  add_library(voro++::voro++ UNKNOWN IMPORTED)
  set_target_properties(voro++::voro++ PROPERTIES IMPORTED_LOCATION ${VOROPP_LIBRARY}
                                                  INTERFACE_INCLUDE_DIRECTORIES ${VOROPP_INCLUDE_DIR})
endif()
mark_as_advanced(VOROPP_INCLUDE_DIR VOROPP_LIBRARY)
