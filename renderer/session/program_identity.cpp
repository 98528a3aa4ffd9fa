// Version, compiler, build type and hash of the sources, as CMake defines them.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/program_identity.h"

#include <fmt/format.h>
#include <kindling_sources_hash.h> // made by every build

#include <gnu/libc-version.h>

namespace kindling {

std::string_view version() { return KINDLING_VERSION; }

std::string_view compiler() {
#if defined(__clang__)
  return "Clang " __clang_version__;
#elif defined(__GNUC__)
  return "GCC " __VERSION__;
#else
  return "unknown compiler";
#endif
}

std::string_view sources_hash() { return KINDLING_SOURCES_HASH; }

std::string_view build_type() { return KINDLING_BUILD_TYPE; }

// The mathematical functions that pixels depend on are those of the C library.
std::string program_identity() {
  return fmt::format("Kindling {} (sources {}, {}, {}, {}, libm {})", version(), sources_hash(), compiler(),
                     KINDLING_TARGET_ARCH, build_type(), gnu_get_libc_version());
}

} // namespace kindling
