# Installs the build, then configures, builds and runs consumer/ against the installed files.
# SPDX-License-Identifier: Apache-2.0
set(prefix ${WORK_DIR}/prefix)
set(build ${WORK_DIR}/build)
file(REMOVE_RECURSE ${WORK_DIR})

function(run what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${what}: ${result}\n${output}")
  endif()
  message(STATUS "${what}: done")
  set(output "${output}" PARENT_SCOPE)
endfunction()

set(sanitizer)
if(SANITIZE)
  set(sanitizer -DCMAKE_CXX_FLAGS=-fsanitize=${SANITIZE})
endif()
run("install" ${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${prefix} --config ${BUILD_TYPE})
run("configure the consumer" ${CMAKE_COMMAND} -S ${CONSUMER_DIR} -B ${build} -G ${GENERATOR} -DCMAKE_MAKE_PROGRAM=${MAKE_PROGRAM}
  -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_BUILD_TYPE=${BUILD_TYPE} -DCMAKE_PREFIX_PATH=${prefix} -DKINDLING_VERSION=${VERSION}
  -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF ${sanitizer})
string(REGEX REPLACE "-- [^\n]*\n" "" noise "${output}") # status lines of CMake itself
if(noise MATCHES "[^ \n]" OR output MATCHES "Imath")
  message(FATAL_ERROR "find_package(kindling) is not quiet:\n${output}")
endif()
run("build the consumer" ${CMAKE_COMMAND} --build ${build} --parallel 2)
run("trace a triangle" ${build}/trace_triangle)
run("render an image" ${build}/render_image ${SCENE})
run("render in ten lines" ${build}/ten_lines ${SCENE} ${WORK_DIR}/ten_lines.png)
if(NOT EXISTS ${WORK_DIR}/ten_lines.png)
  message(FATAL_ERROR "ten_lines wrote no image")
endif()
run("render in a window's loop" ${build}/window_loop ${SCENE} ${WORK_DIR}/window_loop.kacc)
# A plugin from the installed template and header, as C, and the header alone as C and C++.
run("build the template of plugins" ${COMPILER} -x c -std=c99 -pedantic -Wall -Wextra -Werror -O2 -shared -fPIC
  -I${prefix}/include ${prefix}/share/kindling/plugin/template.c -o ${WORK_DIR}/libtemplate.so)
foreach(language c c++)
  run("compile the plugins' header as ${language}" ${COMPILER} -x ${language} -Wall -Wextra -pedantic -fsyntax-only -Wno-pragma-once-outside-header
    ${prefix}/include/kindling_accelerator.h)
endforeach()
run("race the template" ${prefix}/bin/kindling shootout ${SCENE} --accel kdtree --plugin ${WORK_DIR}/libtemplate.so
  --rays-per-kind 100 --repeat 1 --build-repeat 1 --size 32x32)
run("the installed program" ${prefix}/bin/kindling --version)
if(NOT output MATCHES "${VERSION}")
  message(FATAL_ERROR "kindling --version printed '${output}', which does not name version ${VERSION}")
endif()
