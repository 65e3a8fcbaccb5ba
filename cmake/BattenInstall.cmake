include(CMakePackageConfigHelpers)
set(batten_cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/batten)

install(EXPORT batten-kernel NAMESPACE batten:: FILE batten-kernel.cmake DESTINATION ${batten_cmake_dir})
if(BATTEN_WITH_IO)
  foreach(library io cad drawings)
    install(EXPORT batten-${library} NAMESPACE batten:: FILE batten-${library}.cmake
            DESTINATION ${batten_cmake_dir})
  endforeach()
endif()
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/batten-config.cmake.in
                              ${PROJECT_BINARY_DIR}/batten-config.cmake
                              INSTALL_DESTINATION ${batten_cmake_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/batten-config-version.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/batten-config.cmake ${PROJECT_BINARY_DIR}/batten-config-version.cmake
              ${CMAKE_CURRENT_LIST_DIR}/FindCHOLMOD.cmake
        DESTINATION ${batten_cmake_dir})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
