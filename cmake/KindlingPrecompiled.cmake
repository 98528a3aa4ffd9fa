# Precompiled third-party headers that most sources include.
#
# Sources still include all that they need: KINDLING_PCH=OFF compiles without, as the preset `alone`
# does.
# SPDX-License-Identifier: Apache-2.0

# add_precompiled(NAME HEADERS a.h... [LIBS libs...]): the targets that take it must be compiled
# with the same flags, and the same definitions of these headers.
function(add_precompiled name)
  cmake_parse_arguments(ARG "" "" "HEADERS;LIBS" ${ARGN})
  add_library(kindling_precompiled_${name} OBJECT EXCLUDE_FROM_ALL ${PROJECT_SOURCE_DIR}/cmake/precompiled/nothing.cpp)
  target_link_libraries(kindling_precompiled_${name} PRIVATE kindling_flags ${ARG_LIBS})
  target_precompile_headers(kindling_precompiled_${name} PRIVATE ${ARG_HEADERS})
endfunction()

# kindling_precompiled(TARGET NAME): not in folders with sanitizers of their own, which are other
# flags.
function(kindling_precompiled target name)
  kindling_sanitized(sanitized)
  if(KINDLING_PCH AND NOT sanitized)
    target_precompile_headers(${target} REUSE_FROM kindling_precompiled_${name})
  endif()
endfunction()

if(KINDLING_PCH)
  set(vectors
    <algorithm> <array> <atomic> <bit> <cmath> <cstdint> <cstring> <filesystem> <functional> <limits> <map> <memory> <optional> <span> <string>
    <string_view> <utility> <vector> <ImathBox.h> <ImathMatrix.h> <ImathQuat.h> <ImathVec.h>)
  add_precompiled(vectors HEADERS ${vectors} LIBS Imath::Imath)
  add_precompiled(formatting HEADERS ${vectors} <fmt/format.h> <nlohmann/json.hpp> LIBS Imath::Imath fmt::fmt)
  # GCC takes the level of optimization from the precompiled headers, too.
  add_precompiled(application HEADERS ${vectors} <variant> <fmt/format.h> <nlohmann/json.hpp> LIBS Imath::Imath fmt::fmt)
  target_compile_options(kindling_precompiled_application PRIVATE $<$<CONFIG:Release>:-O1>)
  if(KINDLING_BUILD_TESTS)
    add_precompiled(tests HEADERS ${vectors} <gtest/gtest.h> LIBS Imath::Imath GTest::gtest)
    target_compile_options(kindling_precompiled_tests PRIVATE $<$<CONFIG:Release>:-O1>)
  endif()
endif()
