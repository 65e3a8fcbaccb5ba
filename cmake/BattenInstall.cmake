# SPDX-License-Identifier: MPL-2.0
include(CMakePackageConfigHelpers)
set(batten_cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/batten)

set(batten_components kernel)
if(BATTEN_WITH_IO)
  list(APPEND batten_components io cad drawings scenes)
endif()
foreach(component ${batten_components})
  install(EXPORT batten-${component} NAMESPACE batten:: FILE batten-${component}.cmake
          DESTINATION ${batten_cmake_dir})
endforeach()
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/batten-config.cmake.in
                              ${PROJECT_BINARY_DIR}/batten-config.cmake
                              INSTALL_DESTINATION ${batten_cmake_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/batten-config-version.cmake
                                 COMPATIBILITY SameMajorVersion)
install(FILES ${PROJECT_BINARY_DIR}/batten-config.cmake ${PROJECT_BINARY_DIR}/batten-config-version.cmake
              ${CMAKE_CURRENT_LIST_DIR}/FindCHOLMOD.cmake
        DESTINATION ${batten_cmake_dir})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

# pkg-config: batten-kernel.pc and so on, for builds without CMake.

# batten_linker_flags(target): puts the linker flags of a library and of all libraries that it links into the global
# property batten_linker_flags, each library before those that it needs.
function(batten_linker_flags target)
  get_property(visited GLOBAL PROPERTY batten_visited)
  string(REGEX REPLACE "^\\$<(LINK_ONLY|BUILD_INTERFACE):(.*)>$" "\\2" target "${target}")
  if(target IN_LIST visited OR target MATCHES "[$]<" OR target STREQUAL "batten_options")
    return()
  endif()
  set_property(GLOBAL APPEND PROPERTY batten_visited "${target}")
  set(flag "")
  set(next "")
  if(TARGET ${target})
    get_target_property(type ${target} TYPE)
    get_target_property(imported ${target} IMPORTED)
    set(property INTERFACE_LINK_LIBRARIES)
    if(NOT imported AND type STREQUAL "STATIC_LIBRARY")
      set(property LINK_LIBRARIES)  # with the private ones
      get_target_property(name ${target} NAME)
      set(flag -l${name})
    elseif(imported AND NOT type STREQUAL "INTERFACE_LIBRARY")
      get_target_property(flag ${target} LOCATION)
    endif()
    get_target_property(next ${target} ${property})
    if(imported)  # a shared library brings the libraries that only it uses
      list(FILTER next EXCLUDE REGEX "LINK_ONLY|NOTFOUND")
    endif()
  elseif(target MATCHES "^-")
    set(flag ${target})
  elseif(target)
    set(flag ${target})
    if(NOT target MATCHES "/")
      set(flag -l${target})
    endif()
  endif()
  string(REGEX REPLACE "^.*/lib([^/]*)[.](so|a)[0-9.]*$" "-l\\1" flag "${flag}")
  foreach(library ${next})
    batten_linker_flags("${library}")
  endforeach()
  if(flag)
    get_property(found GLOBAL PROPERTY batten_linker_flags)
    set_property(GLOBAL PROPERTY batten_linker_flags ${flag} ${found})
  endif()
endfunction()

# batten_pkg_config(name description): writes and installs batten-NAME.pc for the library batten::NAME.
function(batten_pkg_config name description)
  set_property(GLOBAL PROPERTY batten_visited "")
  set_property(GLOBAL PROPERTY batten_linker_flags "")
  batten_linker_flags(batten_${name})
  get_property(flags GLOBAL PROPERTY batten_linker_flags)
  list(REMOVE_DUPLICATES flags)
  list(JOIN flags " " flags)
  set(folder ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
  file(RELATIVE_PATH to_prefix /${folder} /)
  string(REGEX REPLACE "/$" "" to_prefix "${to_prefix}")
  file(WRITE ${PROJECT_BINARY_DIR}/batten-${name}.pc
"prefix=\${pcfiledir}/${to_prefix}
Name: batten-${name}
Description: ${description}
Version: ${PROJECT_VERSION}
Requires: eigen3
Cflags: -std=c++20 -I\${prefix}/${CMAKE_INSTALL_INCLUDEDIR}
Libs: -L\${prefix}/${CMAKE_INSTALL_LIBDIR} ${flags}
")
  install(FILES ${PROJECT_BINARY_DIR}/batten-${name}.pc DESTINATION ${folder})
endfunction()

batten_pkg_config(kernel "finite-element kernel for continuous surfaces: curves, surfaces, sculpting, shells")
batten_pkg_config(mesh "deformation of meshes and mesh sequences with exact form features")
if(BATTEN_WITH_IO)
  batten_pkg_config(io "mesh, deck and VTK files, pictures and scenes of Batten")
  batten_pkg_config(cad "STEP, IGES and BREP files of Batten")
  batten_pkg_config(drawings "curve files and drawings of Batten")
  batten_pkg_config(scenes "from scenes to shapes, stresses and files: the types of batten/batten.h")
endif()

# check_built.cmake: stops an installation, before anything is copied, if targets have not been built.
get_property(batten_installed GLOBAL PROPERTY batten_installed)
set(check "set(missing)\n")
foreach(entry ${batten_installed})
  string(REGEX MATCH "^([a-z]+):(.*)$" all "${entry}")
  set(component ${CMAKE_MATCH_1})
  set(target ${CMAKE_MATCH_2})
  string(APPEND check
"if((NOT CMAKE_INSTALL_COMPONENT OR CMAKE_INSTALL_COMPONENT STREQUAL \"${component}\") AND NOT EXISTS \"$<TARGET_FILE:${target}>\")
  list(APPEND missing ${target})
endif()
")
endforeach()
string(APPEND check "if(missing)
  list(JOIN missing \" \" missing)
  message(FATAL_ERROR \"Nothing was installed: these targets have not been built: \${missing}. Build everything \"
    \"(cmake --build ${PROJECT_BINARY_DIR}), or install single components (--component program, dev, studio, python).\")
endif()
")
file(GENERATE OUTPUT ${PROJECT_BINARY_DIR}/check_built.cmake CONTENT "${check}")
