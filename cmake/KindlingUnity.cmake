# Unity builds: sources of a folder are compiled together, a few at a time.
#
# A source by itself takes most of its time for headers. KINDLING_UNITY=OFF compiles each alone, as
# the preset `alone` does to find missing includes. Names in anonymous namespaces must differ within
# a folder.
# SPDX-License-Identifier: Apache-2.0

if(KINDLING_UNITY)
  set(CMAKE_UNITY_BUILD ON)
  # Larger groups take less time in all, but more after a change to one source.
  set(CMAKE_UNITY_BUILD_BATCH_SIZE 5)
  # GCC treats an included source as a header, whose classes must not have members of anonymous
  # namespaces.
  add_compile_options($<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endif()

# compile_alone(sources...): compiles these sources of the calling folder by themselves. For sources
# with macros, instruction sets or a third-party implementation of their own.
function(compile_alone)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON SKIP_PRECOMPILE_HEADERS ON)
endfunction()
