# SPDX-License-Identifier: MPL-2.0
# lib3mf 1, which writes 3MF files (its version 2 has another interface). The target batten_3mf has its headers.
find_path(LIB3MF_INCLUDE_DIR Model/COM/NMR_DLLInterfaces.h PATH_SUFFIXES lib3mf)
find_library(LIB3MF_LIBRARY 3MF)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Lib3mf REQUIRED_VARS LIB3MF_LIBRARY LIB3MF_INCLUDE_DIR)
mark_as_advanced(LIB3MF_INCLUDE_DIR LIB3MF_LIBRARY)
if(Lib3mf_FOUND AND NOT TARGET batten_3mf)
  add_library(batten_3mf INTERFACE)
  target_include_directories(batten_3mf SYSTEM INTERFACE ${LIB3MF_INCLUDE_DIR})
endif()
