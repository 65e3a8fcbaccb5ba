# SPDX-License-Identifier: MPL-2.0
# Debian packages by CPack; scripts/package makes them. What is installed belongs to one component a package: program,
# dev, studio, freecad, mpi, python; by default dev (CMakeLists.txt).
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME batten)
set(CPACK_PACKAGE_VENDOR "Batten")
set(BATTEN_MAINTAINER "Batten developers <batten@users.noreply.github.com>" CACHE STRING "Who answers for Debian packages")
set(CPACK_PACKAGE_CONTACT "${BATTEN_MAINTAINER}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS OFF)
set(CPACK_DEBIAN_PACKAGE_SECTION science)

# batten_package(COMPONENT NAME FIRST_LINE MORE): what its description says.
macro(batten_package component name first more)
  string(TOUPPER ${component} upper)
  set(package ${name})
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name})
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${first}\n${more}")
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  configure_file(${PROJECT_SOURCE_DIR}/cmake/packages/changelog.in ${PROJECT_BINARY_DIR}/packages/changelog.${name} @ONLY)
  execute_process(COMMAND gzip -9nf ${PROJECT_BINARY_DIR}/packages/changelog.${name})
  install(FILES ${PROJECT_BINARY_DIR}/packages/changelog.${name}.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name}
          RENAME changelog.gz COMPONENT ${component})
  install(FILES ${PROJECT_SOURCE_DIR}/cmake/packages/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name}
          COMPONENT ${component})
endmacro()

set(CPACK_COMPONENTS_ALL)
string(TIMESTAMP batten_package_date "%a, %d %b %Y %H:%M:%S +0000" UTC)

if(TARGET batten_cli)
  batten_package(program batten "surfaces from character lines: skinned, sculpted, analysed"
"Batten skins lines that a designer drew with continuous finite-element
surfaces, sculpts these live by pressures, points and springs while
constraints hold exactly, computes stresses on the same elements, edits
meshes whose form features stay rigid, and deforming meshes. It writes STEP,
VTK and CalculiX files.

This package holds the command line.")
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "xvfb, xauth")
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "calculix-ccx, batten-studio")
  # Man pages, by scripts/package; the completion of bash; examples.
  file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/man/program)
  install(DIRECTORY ${PROJECT_BINARY_DIR}/man/program/ DESTINATION ${CMAKE_INSTALL_DATADIR}/man/man1 COMPONENT program)
  install(FILES ${PROJECT_SOURCE_DIR}/cmake/packages/batten.bash RENAME batten COMPONENT program
          DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/examples/ DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/batten/examples COMPONENT program
          FILES_MATCHING PATTERN "*.toml" PATTERN "*.csv" PATTERN "*.json" PATTERN "*.obj" PATTERN "*.bdf" PATTERN "*.svg")
endif()

batten_package(dev libbatten-dev "finite-element kernel for continuous surfaces: headers, libraries"
"Static libraries and headers of Batten for C++20 programs:
find_package(batten) gives batten::kernel and batten::mesh,
COMPONENTS io cad drawings the readers and writers of files.")
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libeigen3-dev, libboost-dev, libsuitesparse-dev, libopenblas-dev, libcgal-dev, libceres-dev, libspectra-dev")
set(CPACK_DEBIAN_DEV_PACKAGE_RECOMMENDS
    "libocct-data-exchange-dev, libvtk9-dev, libtomlplusplus-dev, nlohmann-json3-dev, libgif-dev, libdxflib-dev, lib2geom-dev, lib3mf-dev")

if(BATTEN_HAS_STUDIO)
  batten_package(studio batten-studio "window in which surfaces are made from lines"
"Draw lines and see the surface between them, push it, move sliders, watch the
stress; mark features of a mesh and move its handles; edit deforming meshes.
What is done is a scene that the command line runs, too.")
  set(CPACK_DEBIAN_STUDIO_PACKAGE_DEPENDS "batten (= ${PROJECT_VERSION})")
  file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/man/studio)
  install(DIRECTORY ${PROJECT_BINARY_DIR}/man/studio/ DESTINATION ${CMAKE_INSTALL_DATADIR}/man/man1 COMPONENT studio)
  install(FILES ${PROJECT_SOURCE_DIR}/cmake/packages/batten-studio.desktop COMPONENT studio
          DESTINATION ${CMAKE_INSTALL_DATADIR}/applications)
  install(FILES ${PROJECT_SOURCE_DIR}/cmake/packages/batten-studio.svg COMPONENT studio
          DESTINATION ${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps)
  install(FILES ${PROJECT_SOURCE_DIR}/cmake/packages/batten-studio.xml COMPONENT studio
          DESTINATION ${CMAKE_INSTALL_DATADIR}/mime/packages)
endif()

if(TARGET batten_cli)
  batten_package(freecad batten-freecad "workbench of Batten for FreeCAD"
"Surfaces between edges and sketches that follow when these change, pressures
and pushes by sliders, fair curves, continuity along shared edges.")
  set(CPACK_DEBIAN_FREECAD_PACKAGE_ARCHITECTURE all)
  set(CPACK_DEBIAN_FREECAD_PACKAGE_SHLIBDEPS OFF)
  set(CPACK_DEBIAN_FREECAD_PACKAGE_DEPENDS "freecad, batten (>= ${PROJECT_VERSION})")
endif()

if(TARGET batten_petsc)
  batten_package(mpi batten-mpi "systems of Batten over several processes"
"A module that batten loads under mpirun: PETSc factors its systems.")
  set(CPACK_DEBIAN_MPI_PACKAGE_DEPENDS "batten (= ${PROJECT_VERSION}), openmpi-bin")
endif()

if(TARGET batten_python)
  batten_package(python python3-batten "finite-element kernel for continuous surfaces: Python module"
"import batten: lines, surfaces, live sessions, deformers and readers as
numpy arrays.")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3, python3-numpy, batten (= ${PROJECT_VERSION})")
endif()
include(CPack)
