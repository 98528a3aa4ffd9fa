# The target `package`: a .deb and a .tar.gz with program, manual page, completions and two scenes.
# SPDX-License-Identifier: Apache-2.0

# Manual page and completions are printed by the program itself, from its table of flags.
set(share ${PROJECT_BINARY_DIR}/share)
add_custom_command(
  OUTPUT ${share}/man/man1/kindling.1.gz ${share}/bash-completion/completions/kindling ${share}/zsh/vendor-completions/_kindling
  COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:kindling> -DSHARE=${share} -P ${CMAKE_CURRENT_LIST_DIR}/package/WriteDocumentation.cmake
  DEPENDS kindling ${CMAKE_CURRENT_LIST_DIR}/package/WriteDocumentation.cmake
  COMMENT "Writing the manual page and the completions" VERBATIM)
if(NOT CMAKE_CROSSCOMPILING)
  add_custom_target(kindling_documentation ALL DEPENDS ${share}/man/man1/kindling.1.gz)
  install(DIRECTORY ${share}/ DESTINATION ${CMAKE_INSTALL_DATADIR} COMPONENT program)
endif()
install(FILES ${PROJECT_SOURCE_DIR}/scenes/cornell_box.glb ${PROJECT_SOURCE_DIR}/scenes/interior.glb
  DESTINATION ${CMAKE_INSTALL_DATADIR}/kindling/scenes COMPONENT program)
install(PROGRAMS ${CMAKE_CURRENT_LIST_DIR}/get_oidn.sh DESTINATION ${CMAKE_INSTALL_DATADIR}/kindling COMPONENT program)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/package/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)

set(CPACK_GENERATOR "DEB;TGZ")
set(CPACK_PACKAGE_NAME kindling)
set(CPACK_PACKAGE_VENDOR "The Kindling authors")
set(CPACK_PACKAGE_CONTACT "The Kindling authors <kindling@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Path tracer for glTF scenes")
set(CPACK_PACKAGE_DESCRIPTION "Kindling renders glTF 2.0 scenes to PNG, JPEG and EXR images, races ray accelerators
against Embree, and measures how rendering scales with threads and machines.")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR})
set(CPACK_PACKAGE_FILE_NAME "kindling-${PROJECT_VERSION}-${CMAKE_SYSTEM_NAME}-${CMAKE_SYSTEM_PROCESSOR}")
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# Videos of frames; get_oidn.sh.
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "ffmpeg, python3-pip")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
# The program alone: headers and libraries are for those who build it.
set(CPACK_INSTALL_CMAKE_PROJECTS "${PROJECT_BINARY_DIR};kindling;program;/")
# Builds the program, and not the tests, before it is packed.
set(CMAKE_SKIP_PACKAGE_ALL_DEPENDENCY ON)
set(CPACK_INSTALL_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/package/BuildProgram.cmake)
include(CPack)
