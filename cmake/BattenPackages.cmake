# SPDX-License-Identifier: MPL-2.0
# Debian packages by CPack; scripts/package makes them. Each installed file belongs to a component, and each component to a
# package: program, doc, dev (default, CMakeLists.txt), studio, freecad, mpi, python.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME batten)
set(CPACK_PACKAGE_VENDOR "Batten")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has a synopsis of its own
set(BATTEN_MAINTAINER "Batten developers <batten@users.noreply.github.com>" CACHE STRING "Maintainer of the Debian packages")
set(CPACK_PACKAGE_CONTACT "${BATTEN_MAINTAINER}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
# The packages of each Debian release have a version of their own, and the newer release has the newer one.
cmake_host_system_information(RESULT batten_debian QUERY DISTRIB_VERSION_ID)
set(CPACK_DEBIAN_PACKAGE_VERSION ${PROJECT_VERSION}~deb${batten_debian})
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS OFF)
set(CPACK_DEBIAN_PACKAGE_SECTION science)

# Binaries of each package, for its copyright file.
set(batten_binaries_program batten batten_cad)
set(batten_binaries_dev batten)
set(batten_binaries_studio batten-studio)
set(batten_binaries_freecad)
set(batten_binaries_doc)
set(batten_binaries_mpi batten_petsc)
set(batten_binaries_python python batten_cad)

# batten_package(COMPONENT NAME SYNOPSIS DESCRIPTION): declares the package of a component.
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
  batten_gpl_libraries(gpl ${batten_binaries_${component}})
  set(batten_licence_note)
  if(gpl)
    list(JOIN gpl ", " gpl)
    set(batten_licence_note
" .
 The binaries of this package are linked with libraries whose licence is the
 GNU General Public License: ${gpl}.
 The binaries as a whole are therefore distributed under that licence,
 version 3 or later (/usr/share/common-licenses/GPL-3).
")
  endif()
  configure_file(${PROJECT_SOURCE_DIR}/cmake/packages/copyright.in ${PROJECT_BINARY_DIR}/packages/copyright.${name} @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/packages/copyright.${name} DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name}
          RENAME copyright COMPONENT ${component})
endmacro()

set(CPACK_COMPONENTS_ALL)
string(TIMESTAMP batten_package_date "%a, %d %b %Y %H:%M:%S +0000" UTC)

if(TARGET batten_cli)
  batten_package(program batten "smooth, sculptable surfaces from curves, and mesh morphing"
"Batten fits smooth (G1) finite-element surfaces through networks of curves.
You can sculpt the surfaces by pressures, forces and springs while the curves
stay in place, compute stresses, natural frequencies and buckling loads on the
same elements, and export STEP, VTK and CalculiX files. Batten also morphs
meshes and mesh sequences, and keeps form features such as holes exact.

This package contains the command-line program and examples.")
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "batten-doc, xvfb, xauth")
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "calculix-ccx, batten-studio")
  # scripts/package writes the man pages.
  file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/man/program)
  install(DIRECTORY ${PROJECT_BINARY_DIR}/man/program/ DESTINATION ${CMAKE_INSTALL_DATADIR}/man/man1 COMPONENT program)
  install(FILES ${PROJECT_SOURCE_DIR}/cmake/packages/batten.bash RENAME batten COMPONENT program
          DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/examples/ DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/batten/examples COMPONENT program
          REGEX "/examples/CMakeLists.txt$|/__pycache__|/[.]ipynb_checkpoints" EXCLUDE)
  # Installed texts call installed programs, compile with the installed library, and have no marks of scripts/numbers.
  install(CODE "set(examples \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR}/doc/batten/examples\")"
          COMPONENT program)
  install(CODE [[
    file(GLOB texts ${examples}/*/README.md)
    foreach(text ${texts})
      get_filename_component(folder ${text} DIRECTORY)
      get_filename_component(folder ${folder} NAME)
      file(READ ${text} content)
      string(REGEX REPLACE "<!--[=/][^>]*-->" "" content "${content}")
      string(REGEX REPLACE "(env )?PYTHONPATH=[./]*build/release/python " "" content "${content}")
      string(REGEX REPLACE "cmake --build build/release --target ([a-z]+)"
             "g++ -O2 examples/${folder}/main.cpp $(pkg-config --cflags --libs batten-scenes) -o \\1" content "${content}")
      string(REPLACE "build/release/bin/" "./" content "${content}")
      file(WRITE ${text} "${content}")
    endforeach()]] COMPONENT program)

  batten_package(doc batten-doc "documents of Batten, a program for surfaces from curves"
"Manuals of all commands and file formats, the theory, and the pictures that the
examples of Batten refer to, as Markdown files.")
  set(CPACK_DEBIAN_DOC_PACKAGE_SECTION doc)
  set(CPACK_DEBIAN_DOC_PACKAGE_ARCHITECTURE all)
  set(CPACK_DEBIAN_DOC_PACKAGE_SHLIBDEPS OFF)
  install(FILES ${PROJECT_SOURCE_DIR}/README.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/batten COMPONENT doc)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/batten COMPONENT doc
          PATTERN "_site" EXCLUDE PATTERN "conf.py" EXCLUDE PATTERN "numbers.toml" EXCLUDE PATTERN "__pycache__" EXCLUDE)
endif()

batten_package(dev libbatten-dev "smooth surfaces from curves, and mesh morphing: C++ library"
"Static libraries and headers of Batten for C++20 programs. In CMake,
find_package(batten) defines batten::kernel and batten::mesh, and the components
io, cad, drawings and scenes add readers and writers of files. Without CMake, use
pkg-config.")
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libeigen3-dev, libboost-dev, libsuitesparse-dev, libopenblas-dev, libcgal-dev, libceres-dev, libspectra-dev")
set(CPACK_DEBIAN_DEV_PACKAGE_RECOMMENDS
    "libocct-data-exchange-dev, libvtk9-dev, libtomlplusplus-dev, nlohmann-json3-dev, libgif-dev, libpng-dev, lib3mf-dev, libzip-dev")

if(BATTEN_HAS_STUDIO)
  batten_package(studio batten-studio "graphical application for smooth surfaces from curves"
"Draw curves, sculpt the surface between them by pressures, forces and sliders,
and see its stresses. Morph meshes and animated meshes while their form features
keep their shape. The program batten runs the saved scenes.")
  set(CPACK_DEBIAN_STUDIO_PACKAGE_DEPENDS "batten (= ${CPACK_DEBIAN_PACKAGE_VERSION})")
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
  batten_package(freecad batten-freecad "FreeCAD workbench for smooth surfaces from curves"
"Fits smooth surfaces between edges and sketches, and updates the surfaces when
the edges or sketches change. Pressures, forces and offsets are sliders, curves
are faired, and adjacent surfaces are joined with G0 or G1 continuity.")
  set(CPACK_DEBIAN_FREECAD_PACKAGE_ARCHITECTURE all)
  set(CPACK_DEBIAN_FREECAD_PACKAGE_SHLIBDEPS OFF)
  set(CPACK_DEBIAN_FREECAD_PACKAGE_DEPENDS "freecad, batten (>= ${CPACK_DEBIAN_PACKAGE_VERSION})")
endif()

if(TARGET batten_petsc)
  batten_package(mpi batten-mpi "smooth surfaces from curves: stress analysis on several processes"
"A module with which batten solves its linear systems by PETSc under mpirun.")
  set(CPACK_DEBIAN_MPI_PACKAGE_DEPENDS "batten (= ${CPACK_DEBIAN_PACKAGE_VERSION}), openmpi-bin")
endif()

if(TARGET batten_python)
  batten_package(python python3-batten "smooth surfaces from curves, and mesh morphing: Python package"
"Curves, surfaces, interactive sessions, deformers and file readers as Python
classes, with NumPy arrays as input and output.")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3, python3-numpy, batten (= ${CPACK_DEBIAN_PACKAGE_VERSION})")
endif()
include(CPack)
