# Installs the headers, a relocatable package for find_package(gelight), and gelight.pc.

include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_DATADIR}/cmake/gelight)
install(DIRECTORY include/gelight DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(TARGETS gelight EXPORT gelight)
if(GELIGHT_BUILD_COMPILED)
  install(TARGETS gelight_compiled gelight_precompiled EXPORT gelight)
endif()
install(EXPORT gelight NAMESPACE gelight:: DESTINATION ${package_dir} FILE gelightTargets.cmake)
configure_package_config_file(cmake/gelightConfig.cmake.in gelightConfig.cmake
  INSTALL_DESTINATION ${package_dir} NO_SET_AND_CHECK_MACRO NO_CHECK_REQUIRED_COMPONENTS_MACRO)
write_basic_package_version_file(gelightConfigVersion.cmake
  COMPATIBILITY SameMinorVersion ARCH_INDEPENDENT)

# Paths in gelight.pc start at where the file itself lies, so that the tree can be moved.
file(RELATIVE_PATH prefix_from_pc /${CMAKE_INSTALL_DATADIR}/pkgconfig /)
configure_file(cmake/gelight.pc.in gelight.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/gelightConfig.cmake
  ${CMAKE_CURRENT_BINARY_DIR}/gelightConfigVersion.cmake DESTINATION ${package_dir})
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/gelight.pc DESTINATION ${CMAKE_INSTALL_DATADIR}/pkgconfig)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
