# Finds every third-party package, once.
#
# The installed package uses the same list. Each package is linked only by the folder that wraps it
# (except for Imath, TBB and fmt).
# SPDX-License-Identifier: Apache-2.0
set(KINDLING_PACKAGES
  "Threads"
  "Imath 3 CONFIG"
  "TBB CONFIG"
  "fmt CONFIG"
  "spdlog CONFIG"
  "PNG"
  "JPEG"
  "ZLIB"
  "zstd CONFIG"
  "OpenEXR 3.1 CONFIG"
  "OpenImageIO CONFIG" # 2.4 or newer; its files refuse other major versions than the one that is asked for
  "OpenColorIO 2.1 CONFIG HINTS /usr/share" # Debian 12's place, which CMake does not search
  "TinyGLTF CONFIG"
  "meshoptimizer CONFIG"
  "draco CONFIG"
  "CLI11 CONFIG"
  "nlohmann_json CONFIG")
if(KINDLING_ONLY_ACCEL)
  set(KINDLING_PACKAGES "Threads" "Imath 3 CONFIG" "TBB CONFIG")
endif()
set(CMAKE_MESSAGE_LOG_LEVEL NOTICE) # silences Debian's Imath, which reports a Python library that is not needed
foreach(package IN LISTS KINDLING_PACKAGES)
  separate_arguments(package)
  find_package(${package} REQUIRED)
endforeach()
unset(CMAKE_MESSAGE_LOG_LEVEL)
if(OpenImageIO_FOUND AND OpenImageIO_VERSION VERSION_LESS 2.4)
  message(FATAL_ERROR "OpenImageIO ${OpenImageIO_VERSION} in ${OpenImageIO_DIR}: 2.4 or newer is needed")
endif()

# Embree 4 where found, else 3.13. Both are wrapped by accel/embree, which includes the right header
# by KINDLING_EMBREE_MAJOR.
find_package(embree 4 QUIET CONFIG)
if(NOT embree_FOUND)
  find_package(embree 3.13 REQUIRED CONFIG)
endif()
string(REGEX MATCH "^[0-9]+" KINDLING_EMBREE_MAJOR "${EMBREE_VERSION}")
message(STATUS "Embree ${EMBREE_VERSION}, TBB ${TBB_VERSION}, Imath ${Imath_VERSION}, OpenImageIO ${OpenImageIO_VERSION}, "
               "OpenColorIO ${OpenColorIO_VERSION}")
if(KINDLING_ONLY_ACCEL)
  return()
endif()

if(KINDLING_BUILD_TESTS)
  find_package(GTest REQUIRED)
  include(GoogleTest)
endif()
if(KINDLING_BUILD_BENCH)
  find_package(benchmark REQUIRED CONFIG)
endif()
