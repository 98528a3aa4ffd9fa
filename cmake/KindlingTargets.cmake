# Targets of a folder: kindling_library(), kindling_test(), kindling_bench(), and their flags.
include(GNUInstallDirs)
include(KindlingUnity)

add_library(kindling_flags INTERFACE)
add_library(kindling::flags ALIAS kindling_flags)
target_compile_features(kindling_flags INTERFACE cxx_std_20)
# No contraction to fused multiply-add: watertight intersection tests and bit-identical images need
# it.
target_compile_options(kindling_flags INTERFACE
  $<BUILD_INTERFACE:-Wall -Wextra -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wno-missing-field-initializers>
  $<BUILD_INTERFACE:-ffp-contract=off -fno-math-errno -fno-trapping-math>)
if(KINDLING_ARCH)
  target_compile_options(kindling_flags INTERFACE $<BUILD_INTERFACE:-march=${KINDLING_ARCH}>)
endif()
if(KINDLING_WARNINGS_AS_ERRORS)
  # GCC 12 reports some inlined copies of vectors as uninitialized, and sums of strings as too long;
  # GCC 14 reports writes of Draco's attributes as overflows. These remain warnings.
  target_compile_options(kindling_flags INTERFACE
    $<BUILD_INTERFACE:-Werror -Wno-error=maybe-uninitialized -Wno-error=array-bounds -Wno-error=stringop-overflow>)
endif()
if(KINDLING_SANITIZE)
  set(kindling_sanitize -fsanitize=${KINDLING_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(kindling_flags INTERFACE $<BUILD_INTERFACE:-fsanitize=${KINDLING_SANITIZE}>)
  if(NOT KINDLING_SANITIZE_FOLDERS)
    target_compile_options(kindling_flags INTERFACE "$<BUILD_INTERFACE:${kindling_sanitize}>")
  endif()
endif()

# kindling_sanitized(VARIABLE): whether the calling folder is one of KINDLING_SANITIZE_FOLDERS.
function(kindling_sanitized variable)
  set(${variable} OFF PARENT_SCOPE)
  file(RELATIVE_PATH here ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  foreach(folder IN LISTS KINDLING_SANITIZE_FOLDERS)
    if("${here}/" MATCHES "^${folder}/")
      set(${variable} ON PARENT_SCOPE)
    endif()
  endforeach()
endfunction()

# kindling_sanitize(TARGET): compiles a target of such a folder with sanitizers and assertions. All
# others stay as they are, so that a build folder that has them needs little more.
function(kindling_sanitize target)
  kindling_sanitized(sanitized)
  if(sanitized)
    target_compile_options(${target} PRIVATE ${kindling_sanitize} -O1 -g1 -UNDEBUG)
  endif()
endfunction()

include(KindlingPrecompiled)

# Every program links these objects by $<TARGET_NAME_IF_EXISTS:kindling_tbb_order>; see
# tests/sanitizers.
if(KINDLING_SANITIZE STREQUAL "thread")
  add_library(kindling_tbb_order OBJECT ${PROJECT_SOURCE_DIR}/tests/sanitizers/tbb_order.cpp)
  target_link_libraries(kindling_tbb_order PRIVATE kindling_flags TBB::tbb)
endif()

# kindling_library(NAME [ORCHESTRATES] SOURCES a.cpp... [PUBLIC libs...] [PRIVATE libs...]): static
# library kindling_NAME, alias kindling::NAME. Include paths are spelled from the root
# ("renderer/base/math.h"). ORCHESTRATES: its time is that of what it calls, so it is compiled at
# -O1, which takes less of the compiler's.
function(kindling_library name)
  cmake_parse_arguments(ARG "ORCHESTRATES" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  set(target kindling_${name})
  if(ARG_SOURCES)
    add_library(${target} STATIC ${ARG_SOURCES})
    target_include_directories(${target} PUBLIC
      $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/kindling>)
    target_link_libraries(${target} PUBLIC kindling_flags ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
    if(ARG_ORCHESTRATES)
      kindling_precompiled(${target} application)
      target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
    elseif(fmt::fmt IN_LIST ARG_PRIVATE)
      kindling_precompiled(${target} formatting)
    else()
      kindling_precompiled(${target} vectors)
    endif()
    kindling_sanitize(${target})
  else()
    add_library(${target} INTERFACE)
    target_include_directories(${target} INTERFACE
      $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/kindling>)
    target_link_libraries(${target} INTERFACE kindling_flags ${ARG_PUBLIC})
  endif()
  add_library(kindling::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  set_property(GLOBAL APPEND PROPERTY KINDLING_LIBRARIES ${target})
endfunction()

# kindling_test(NAME LABEL unit|statistical|image [TIMEOUT seconds] [PROGRAM program] [ALONE]
# SOURCES a.cpp... LIBS libs...): GoogleTest program test_NAME; each of its tests is the ctest test
# NAME.Suite.Test. With PROGRAM the program is test_PROGRAM, which several names share to save
# compile time; a suite then belongs to one of the names. ALONE: sources are not compiled together.
# Tests are compiled at -O1, in three fifths of the time of -O3, since most of their run time is
# that of the libraries that they call.
function(kindling_test name)
  cmake_parse_arguments(ARG "ALONE" "LABEL;TIMEOUT;PROGRAM" "SOURCES;LIBS" ${ARGN})
  if(NOT ARG_LABEL MATCHES "^(unit|statistical|image)$" OR ARG_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "kindling_test(${name}): LABEL must be unit, statistical or image, not '${ARG_LABEL}' (${ARG_UNPARSED_ARGUMENTS})")
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  set(filter)
  if(ARG_PROGRAM)
    set(target test_${ARG_PROGRAM})
    kindling_test_filter(suites ${name} ${ARG_SOURCES})
    set(filter TEST_FILTER ${suites})
  else()
    set(target test_${name})
  endif()
  if(TARGET ${target})
    target_sources(${target} PRIVATE ${ARG_SOURCES})
  else()
    add_executable(${target} ${ARG_SOURCES})
    add_dependencies(kindling_tests ${target})
    kindling_precompiled(${target} tests)
    target_link_libraries(${target} PRIVATE kindling_flags GTest::gtest GTest::gtest_main $<TARGET_NAME_IF_EXISTS:kindling_tbb_order>)
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
    target_compile_definitions(${target} PRIVATE
      KINDLING_SOURCE_DIR="${PROJECT_SOURCE_DIR}" KINDLING_BINARY_DIR="${PROJECT_BINARY_DIR}")
    kindling_sanitize(${target})
  endif()
  target_link_libraries(${target} PRIVATE ${ARG_LIBS})
  if(ARG_ALONE)
    set_target_properties(${target} PROPERTIES UNITY_BUILD OFF)
  endif()
  gtest_discover_tests(${target} TEST_PREFIX "${name}." ${filter} NO_PRETTY_VALUES DISCOVERY_TIMEOUT 60
    PROPERTIES LABELS "${ARG_LABEL}" TIMEOUT ${ARG_TIMEOUT})
endfunction()

# kindling_test_filter(VARIABLE NAME sources...): the filter of GoogleTest for the suites in these
# sources, which no other NAME may have. CMake runs again when one of them changes.
function(kindling_test_filter variable name)
  set(filters)
  foreach(source IN LISTS ARGN)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${source})
    file(STRINGS ${source} lines REGEX "^TEST(_F|_P)?\\(")
    foreach(line IN LISTS lines)
      string(REGEX REPLACE "^TEST[_FP]*\\(([A-Za-z0-9_]+).*" "\\1" suite "${line}")
      get_property(owner DIRECTORY PROPERTY KINDLING_TEST_NAME_OF_${suite})
      if(owner AND NOT owner STREQUAL name)
        message(FATAL_ERROR "The tests ${owner} and ${name} share a program and both have a suite ${suite}; rename one")
      endif()
      set_property(DIRECTORY PROPERTY KINDLING_TEST_NAME_OF_${suite} ${name})
      list(APPEND filters "${suite}.*" "*/${suite}.*")
    endforeach()
  endforeach()
  list(REMOVE_DUPLICATES filters)
  list(JOIN filters ":" filters)
  set(${variable} "${filters}" PARENT_SCOPE)
endfunction()

# kindling_bench(NAME SOURCES a.cpp... LIBS libs...): Google Benchmark program bench_NAME.
function(kindling_bench name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBS" ${ARGN})
  add_executable(bench_${name} ${ARG_SOURCES})
  target_link_libraries(bench_${name} PRIVATE kindling_flags ${ARG_LIBS} benchmark::benchmark
    $<TARGET_NAME_IF_EXISTS:kindling_tbb_order>)
  set_target_properties(bench_${name} PROPERTIES UNITY_BUILD OFF) # has few sources
  kindling_precompiled(bench_${name} vectors)
  target_compile_definitions(bench_${name} PRIVATE KINDLING_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endfunction()
