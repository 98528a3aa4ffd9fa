# Writes a header with a hash of all sources of the program.
#
#   cmake -DROOT=REPOSITORY -DOUTPUT=HEADER -P HashSources.cmake
#
# Runs at every build and touches the header only if the hash has changed. It needs no version
# control; the same sources give the same hash everywhere.
set(patterns "")
foreach(folder renderer accel)
  foreach(name *.h *.cpp CMakeLists.txt)
    list(APPEND patterns "${ROOT}/${folder}/${name}")
  endforeach()
endforeach()
file(GLOB_RECURSE files LIST_DIRECTORIES false RELATIVE "${ROOT}" ${patterns})
list(APPEND files CMakeLists.txt cmake/KindlingTargets.cmake)
list(SORT files COMPARE STRING)
set(lines "")
foreach(file IN LISTS files)
  file(SHA256 "${ROOT}/${file}" hash)
  string(APPEND lines "${hash} ${file}\n")
endforeach()
string(SHA256 hash "${lines}")
string(SUBSTRING "${hash}" 0 16 hash)
set(text "// Written by cmake/HashSources.cmake.\n#pragma once\n#define KINDLING_SOURCES_HASH \"${hash}\"\n")
set(present "")
if(EXISTS "${OUTPUT}")
  file(READ "${OUTPUT}" present)
endif()
if(NOT present STREQUAL text)
  file(WRITE "${OUTPUT}" "${text}")
endif()
