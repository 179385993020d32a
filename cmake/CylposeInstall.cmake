# find_package(cylpose) for users: the exported targets, their dependencies and the version.

include(CMakePackageConfigHelpers)
set(cylpose_cmake_dir "${CMAKE_INSTALL_LIBDIR}/cmake/cylpose")
configure_package_config_file(cmake/cylposeConfig.cmake.in "${PROJECT_BINARY_DIR}/cylposeConfig.cmake"
                              INSTALL_DESTINATION "${cylpose_cmake_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/cylposeConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(EXPORT cylposeTargets NAMESPACE cylpose:: DESTINATION "${cylpose_cmake_dir}")
install(EXPORT cylposeGraphTargets NAMESPACE cylpose:: DESTINATION "${cylpose_cmake_dir}")
install(FILES "${PROJECT_BINARY_DIR}/cylposeConfig.cmake" "${PROJECT_BINARY_DIR}/cylposeConfigVersion.cmake"
        DESTINATION "${cylpose_cmake_dir}")
