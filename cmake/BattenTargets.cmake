# batten_library(core SOURCES a.cpp … HEADERS a.h … LINKS batten::x …): one folder with its sub-folders, one
# library.
add_library(batten_options INTERFACE)
target_compile_features(batten_options INTERFACE cxx_std_20)
target_compile_options(batten_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow=local)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # GCC 12 sees overlapping copies in plain std::string concatenation, and endless ones where its headers are precompiled.
  target_compile_options(batten_options INTERFACE -Wno-restrict)
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

# What nearly every source parses: half of the time of a build without it. The dev and sanitize presets do without
# (CMAKE_DISABLE_PRECOMPILE_HEADERS), so that a source which forgets an include shows.
set(batten_common_headers <Eigen/Core> <Eigen/Geometry> <Eigen/LU> <Eigen/SparseCore> <algorithm> <array> <cmath>
    <filesystem> <functional> <map> <memory> <numbers> <optional> <set> <string> <vector>)

set_property(GLOBAL PROPERTY batten_folders "")

# batten_precompile(target): the common headers once for all libraries, which are compiled with the same options.
function(batten_precompile target)
  if(TARGET batten_core AND NOT target STREQUAL "batten_core")
    target_precompile_headers(${target} REUSE_FROM batten_core)
  else()
    target_precompile_headers(${target} PRIVATE ${batten_common_headers})
  endif()
endfunction()

function(batten_library folder)
  cmake_parse_arguments(ARG "" "" "SOURCES;HEADERS;LINKS;PRIVATE_LINKS" ${ARGN})
  string(REPLACE "/" "_" name ${folder})
  add_library(batten_${name} STATIC ${ARG_SOURCES} ${ARG_HEADERS})
  add_library(batten::${name} ALIAS batten_${name})
  set_target_properties(batten_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(batten_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(batten_${name} PUBLIC ${ARG_LINKS}
                        PRIVATE $<BUILD_INTERFACE:batten_options> ${ARG_PRIVATE_LINKS})
  target_compile_features(batten_${name} PUBLIC cxx_std_20)  # headers have std::span
  batten_precompile(batten_${name})
  if(folder STREQUAL "io")
    set(export batten-io)
  else()
    set(export batten-kernel)
  endif()
  install(TARGETS batten_${name} EXPORT ${export} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  foreach(header ${ARG_HEADERS})
    get_filename_component(subfolder ${folder}/${header} DIRECTORY)
    install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/batten/${subfolder})
  endforeach()
endfunction()
