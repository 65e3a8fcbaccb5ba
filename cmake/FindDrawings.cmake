# SPDX-License-Identifier: MPL-2.0
# Libraries that read drawings: dxflib and lib2geom. The target batten_drawing_libraries has their headers.
find_path(DXFLIB_INCLUDE_DIR dl_dxf.h PATH_SUFFIXES dxflib)
find_library(DXFLIB_LIBRARY dxflib)
file(GLOB versioned_2geom LIST_DIRECTORIES true /usr/include/2geom-*)
find_path(LIB2GEOM_INCLUDE_DIR 2geom/svg-path-parser.h HINTS ${versioned_2geom})
find_library(LIB2GEOM_LIBRARY 2geom)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Drawings REQUIRED_VARS DXFLIB_LIBRARY DXFLIB_INCLUDE_DIR LIB2GEOM_LIBRARY
                                  LIB2GEOM_INCLUDE_DIR)
mark_as_advanced(DXFLIB_INCLUDE_DIR DXFLIB_LIBRARY LIB2GEOM_INCLUDE_DIR LIB2GEOM_LIBRARY)
if(Drawings_FOUND AND NOT TARGET batten_drawing_libraries)
  add_library(batten_drawing_libraries INTERFACE)
  target_include_directories(batten_drawing_libraries SYSTEM INTERFACE ${DXFLIB_INCLUDE_DIR} ${LIB2GEOM_INCLUDE_DIR})
endif()
