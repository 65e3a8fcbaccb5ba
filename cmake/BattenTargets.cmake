# SPDX-License-Identifier: MPL-2.0
# batten_library(core SOURCES a.cpp … HEADERS a.h … LINKS batten::x …): the sources of one folder with
# its sub-folders as one static library batten::core; NAME gives it another name.
add_library(batten_options INTERFACE)
target_compile_features(batten_options INTERFACE cxx_std_20)
target_compile_options(batten_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow=local)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # GCC 12 sees overlapping copies in plain std::string concatenation, and endless ones where its headers are precompiled.
  target_compile_options(batten_options INTERFACE -Wno-restrict)
  # A larger heap before GCC collects its garbage: a tenth less time for an eighth more memory (1.0 GB per process).
  target_compile_options(batten_options INTERFACE "SHELL:--param ggc-min-expand=100"
                         "SHELL:--param ggc-min-heapsize=524288")
  if(NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)
    target_compile_options(batten_options INTERFACE -Wno-array-bounds -Wno-stringop-overflow
                           -Wno-stringop-overread)
  endif()
endif()
if(BATTEN_WERROR)
  target_compile_options(batten_options INTERFACE -Werror)
endif()
if(BATTEN_ASSERTIONS)
  target_compile_definitions(batten_options INTERFACE _GLIBCXX_ASSERTIONS)
  string(REPLACE "-DNDEBUG" "" CMAKE_CXX_FLAGS_RELWITHDEBINFO "${CMAKE_CXX_FLAGS_RELWITHDEBINFO}")
endif()
if(BATTEN_SANITIZE)
  target_compile_options(batten_options INTERFACE -fsanitize=address,undefined
                         -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
  target_link_options(batten_options INTERFACE -fsanitize=address,undefined)
  target_compile_definitions(batten_options INTERFACE BATTEN_NO_CLONES=1)
endif()
if(BATTEN_FUZZ)
  target_compile_options(batten_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

# Headers that nearly every source parses: half of the time of a build without them. The dev and sanitize presets do
# without (CMAKE_DISABLE_PRECOMPILE_HEADERS), so that a source which forgets an include shows. The kernel is compiled
# for speed (-O3), files and programs for a short build (-O1): the two need precompiled headers of their own.
set(batten_kernel_headers <Eigen/Core> <Eigen/Geometry> <Eigen/LU> <Eigen/SparseCore> <algorithm> <array> <cmath>
    <filesystem> <functional> <map> <memory> <numbers> <optional> <set> <sstream> <string> <unordered_map> <variant>
    <vector>)
set(batten_program_headers ${batten_kernel_headers} <toml++/toml.h> <nlohmann/json.hpp>
    "${PROJECT_SOURCE_DIR}/io/scene/scene.h" "${PROJECT_SOURCE_DIR}/io/report/report.h"
    "${PROJECT_SOURCE_DIR}/skinning/model/model_layout.h" "${PROJECT_SOURCE_DIR}/mesh/triangle_mesh.h")

# batten_installed(component target): has the installation of a component check that the target has been built.
function(batten_installed component target)
  set_property(GLOBAL APPEND PROPERTY batten_installed ${component}:${target})
endfunction()

# batten_precompile(target): the headers of the kernel, once for all libraries of it.
function(batten_precompile target)
  if(TARGET batten_core AND NOT target STREQUAL "batten_core")
    target_precompile_headers(${target} REUSE_FROM batten_core)
  else()
    target_precompile_headers(${target} PRIVATE ${batten_kernel_headers})
  endif()
endfunction()

# batten_compile_fast(target): a library of files or of a program, which is compiled with -O1.
function(batten_compile_fast target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  # The precompiled headers are valid with the same definitions only.
  target_link_libraries(${target} PRIVATE tomlplusplus::tomlplusplus nlohmann_json::nlohmann_json
                                          ${VTK_LIBRARIES})
  if(TARGET batten_io AND NOT target STREQUAL "batten_io")
    target_precompile_headers(${target} REUSE_FROM batten_io)
  else()
    target_precompile_headers(${target} PRIVATE ${batten_program_headers})
  endif()
endfunction()

function(batten_library folder)
  cmake_parse_arguments(ARG "" "NAME" "SOURCES;HEADERS;LINKS;PRIVATE_LINKS" ${ARGN})
  string(REPLACE "/" "_" name ${folder})
  if(ARG_NAME)
    set(name ${ARG_NAME})
  endif()
  add_library(batten_${name} STATIC ${ARG_SOURCES} ${ARG_HEADERS})
  add_library(batten::${name} ALIAS batten_${name})
  set_target_properties(batten_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(batten_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(batten_${name} PUBLIC ${ARG_LINKS}
                        PRIVATE $<BUILD_INTERFACE:batten_options> ${ARG_PRIVATE_LINKS})
  target_compile_features(batten_${name} PUBLIC cxx_std_20)  # headers have std::span
  if(folder MATCHES "^(io|scenes)$")
    batten_compile_fast(batten_${name})
  else()
    batten_precompile(batten_${name})
  endif()
  set(export batten-kernel)
  if(folder MATCHES "^(io|scenes)$")
    set(export batten-${name})
  endif()
  install(TARGETS batten_${name} EXPORT ${export} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  batten_installed(dev batten_${name})
  foreach(header ${ARG_HEADERS})
    get_filename_component(subfolder ${folder}/${header} DIRECTORY)
    install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/batten/${subfolder})
  endforeach()
endfunction()

# batten_library_group(kernel batten::core …): one name for several libraries, as users link them.
function(batten_library_group name)
  add_library(batten_${name} INTERFACE)
  add_library(batten::${name} ALIAS batten_${name})
  set_target_properties(batten_${name} PROPERTIES EXPORT_NAME ${name})
  target_link_libraries(batten_${name} INTERFACE ${ARGN})
  install(TARGETS batten_${name} EXPORT batten-kernel)
endfunction()
