# Toolchain that compiles for arm64, without linking, by the headers of this machine's libraries.
# It shows that the sources need no x86; linking would need the libraries of that processor.
#
#   cmake -B build/aarch64 -G Ninja --toolchain cmake/Aarch64Toolchain.cmake \
#     -DKINDLING_BUILD_TESTS=OFF -DKINDLING_BUILD_BENCH=OFF
# SPDX-License-Identifier: Apache-2.0
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
# The generic headers of this machine, behind those of the cross compiler; last those that a library
# keeps apart by processor (libjpeg's jconfig.h).
set(CMAKE_CXX_FLAGS_INIT "-idirafter /usr/include -idirafter /usr/include/x86_64-linux-gnu")
set(CMAKE_LIBRARY_ARCHITECTURE x86_64-linux-gnu) # where CMake looks for packages
