# Sources of a folder are compiled together, a few at a time: most of the time of one alone is for headers. KINDLING_UNITY=OFF compiles each
# alone; the preset `alone` does, which finds missing includes. So names in anonymous namespaces are told apart within a folder.
# SPDX-License-Identifier: Apache-2.0

if(KINDLING_UNITY)
  set(CMAKE_UNITY_BUILD ON)
  # More at a time take less time in all, and more after a change to one.
  set(CMAKE_UNITY_BUILD_BATCH_SIZE 5)
  # GCC takes an included source for a header, whose classes may not have members of anonymous namespaces.
  add_compile_options($<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endif()

# compile_alone(sources...): of the calling folder. For what has macros, instruction sets or a third-party implementation of its own.
function(compile_alone)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON SKIP_PRECOMPILE_HEADERS ON)
endfunction()
