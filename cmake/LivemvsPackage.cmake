# The installed package: find_package(livemvs) gives the targets livemvs::core, livemvs::pipeline and so on.
include(CMakePackageConfigHelpers)

set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/livemvs")
configure_package_config_file(cmake/livemvsConfig.cmake.in "${PROJECT_BINARY_DIR}/livemvsConfig.cmake"
                              INSTALL_DESTINATION "${package_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/livemvsConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(EXPORT livemvs NAMESPACE livemvs:: FILE livemvsTargets.cmake DESTINATION "${package_dir}" COMPONENT development)
install(FILES "${PROJECT_BINARY_DIR}/livemvsConfig.cmake" "${PROJECT_BINARY_DIR}/livemvsConfigVersion.cmake"
        "${PROJECT_SOURCE_DIR}/cmake/FindOpenCvAruco.cmake"
        DESTINATION "${package_dir}" COMPONENT development)
install(FILES LICENSE NOTICE DESTINATION "${CMAKE_INSTALL_DOCDIR}")
