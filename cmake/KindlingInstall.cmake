# Install rules: the program, the libraries, the headers and a package for find_package(kindling).
# SPDX-License-Identifier: Apache-2.0
include(CMakePackageConfigHelpers)
set(KINDLING_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/kindling)

get_property(kindling_libraries GLOBAL PROPERTY KINDLING_LIBRARIES)
set_target_properties(kindling_flags PROPERTIES EXPORT_NAME flags)
install(TARGETS kindling_flags ${kindling_libraries} EXPORT kindlingTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT kindlingTargets NAMESPACE kindling:: DESTINATION ${KINDLING_PACKAGE_DIR})

install(TARGETS kindling RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/accel ${PROJECT_SOURCE_DIR}/renderer
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/kindling FILES_MATCHING PATTERN "*.h" PATTERN "renderer/python" EXCLUDE)
# Everything that a plugin of `kindling shootout` needs.
install(FILES ${PROJECT_SOURCE_DIR}/accel/plugin/kindling_accelerator.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  COMPONENT program)
install(FILES ${PROJECT_SOURCE_DIR}/accel/plugin/template.c DESTINATION ${CMAKE_INSTALL_DATADIR}/kindling/plugin
  COMPONENT program)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/kindlingConfig.cmake.in
  ${PROJECT_BINARY_DIR}/cmake/kindlingConfig.cmake INSTALL_DESTINATION ${KINDLING_PACKAGE_DIR})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/cmake/kindlingConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/cmake/kindlingConfig.cmake ${PROJECT_BINARY_DIR}/cmake/kindlingConfigVersion.cmake
  DESTINATION ${KINDLING_PACKAGE_DIR})
