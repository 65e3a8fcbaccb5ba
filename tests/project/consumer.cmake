# SPDX-License-Identifier: MPL-2.0
# Installs Batten into an empty folder, then builds and runs programs that use the installed package: by CMake
# components, by pkg-config, and the project of examples/embed.
#
# BUILD, SOURCE: folders; GENERATOR; COMPONENTS: "io,cad,drawings,scenes" as far as they were built; PREFIX: an
# installation to use instead (of unpacked Debian packages).
cmake_minimum_required(VERSION 3.22)
string(REPLACE "," ";" COMPONENTS "${COMPONENTS}")
set(work ${BUILD}/consumer)
set(of_packages OFF)
if(PREFIX)
  set(work ${BUILD}/consumer-of-packages)
  set(of_packages ON)  # installed by the same rules: the project of examples/embed is built from the other one
endif()
file(REMOVE_RECURSE ${work})
file(MAKE_DIRECTORY ${work})
set(flags "")
if(SANITIZE)
  set(flags "-fsanitize=address,undefined")
endif()

macro(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output
                  WORKING_DIRECTORY ${work})
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "failed: ${ARGN}\n${output}")
  endif()
endmacro()

if(NOT PREFIX)
  set(PREFIX ${work}/prefix)
  run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${PREFIX} --component dev)
endif()
# Where a target has not been built, nothing is installed, and the message names it.
file(READ ${BUILD}/check_built.cmake check)
string(REPLACE "${BUILD}/core" "${work}/missing" check "${check}")
file(WRITE ${work}/check_built.cmake "${check}")
execute_process(COMMAND ${CMAKE_COMMAND} -P ${work}/check_built.cmake RESULT_VARIABLE result ERROR_VARIABLE output)
if(result EQUAL 0 OR NOT output MATCHES "Nothing was installed.*batten_core")
  message(FATAL_ERROR "an installation without batten_core was not refused:\n${output}")
endif()

string(REPLACE ";" "," components "${COMPONENTS}")
run(${CMAKE_COMMAND} -S ${SOURCE}/tests/project/consumer -B ${work}/build -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_PREFIX_PATH=${PREFIX} -DCMAKE_CXX_FLAGS=${flags} -DWITH=${components})
run(${CMAKE_COMMAND} --build ${work}/build)
run(${CMAKE_CTEST_COMMAND} --test-dir ${work}/build --output-on-failure)
message(STATUS "${output}")

if("scenes" IN_LIST COMPONENTS AND NOT SANITIZE AND NOT of_packages)
  run(${CMAKE_COMMAND} -S ${SOURCE}/examples/embed -B ${work}/embed -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release
      -DCMAKE_PREFIX_PATH=${PREFIX})
  run(${CMAKE_COMMAND} --build ${work}/embed)
  run(${CMAKE_COMMAND} -E env --unset=DISPLAY BATTEN_XVFB= ${work}/embed/network)
  run(${CMAKE_COMMAND} -E env --unset=DISPLAY BATTEN_XVFB= ${work}/embed/drags)
  run(${work}/embed/holes ${SOURCE}/examples/10-plate-with-holes/plate.obj)
  run(${work}/embed/plate)
endif()

# pkg-config, without CMake.
find_program(PKG_CONFIG NAMES pkgconf pkg-config)
find_program(CXX NAMES c++)
if(PKG_CONFIG AND CXX)
  set(component kernel)
  if("scenes" IN_LIST COMPONENTS)
    set(component scenes)
  endif()
  file(GLOB_RECURSE found ${PREFIX}/*/batten-${component}.pc)
  get_filename_component(folder "${found}" DIRECTORY)
  run(${CMAKE_COMMAND} -E env PKG_CONFIG_PATH=${folder} ${PKG_CONFIG} --cflags --libs batten-${component})
  separate_arguments(arguments UNIX_COMMAND "${output}")
  if(SANITIZE)
    list(APPEND arguments -fsanitize=address,undefined)
  endif()
  run(${CXX} ${SOURCE}/tests/project/consumer/${component}.cpp -o ${work}/by_pkg_config ${arguments})
  run(${work}/by_pkg_config)
endif()
