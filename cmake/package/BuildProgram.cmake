# Run by CPack before it installs: builds what the package holds.
# SPDX-License-Identifier: Apache-2.0
list(GET CPACK_INSTALL_CMAKE_PROJECTS 0 build)
execute_process(COMMAND ${CMAKE_COMMAND} --build ${build} --target kindling kindling_documentation COMMAND_ERROR_IS_FATAL ANY)
