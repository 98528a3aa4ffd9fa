// What this program is and was built with. KINDLING_VERSION, KINDLING_TARGET_ARCH and KINDLING_BUILD_TYPE come from CMake.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/terminal/version.h"

#include "accel/make_accelerator.h"
#include "renderer/image/library_versions.h"

#include <CLI/Version.hpp>
#include <fmt/format.h>
#include <kindling_sources_hash.h> // made by every build
#include <spdlog/version.h>
#include <tbb/version.h>

#include <gnu/libc-version.h>

namespace kindling::app {

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

std::string program_identity() {
  return fmt::format("Kindling {} (sources {}, {}, {}, {}, libm {})", version(), KINDLING_SOURCES_HASH, compiler(),
                     KINDLING_TARGET_ARCH, KINDLING_BUILD_TYPE, gnu_get_libc_version());
}

std::string version_text() {
  std::string text = fmt::format("kindling {}\n", version());
  text += fmt::format("sources      {}\ncompiler     {}, {}\n", KINDLING_SOURCES_HASH, compiler(), KINDLING_BUILD_TYPE);
  text += "accelerators";
  for (const accel::Kind kind : {accel::Kind::embree, accel::Kind::kdtree, accel::Kind::brute_force})
    text += fmt::format("{} {} ({})", kind == accel::Kind::embree ? "" : ",", accel::kind_name(kind),
                        accel::kind_description(kind));
  text += fmt::format("\noneTBB       {}\n", TBB_runtime_version());
  for (const auto& [name, number] : image_library_versions()) text += fmt::format("{:<12} {}\n", name, number);
  text +=
      fmt::format("CLI11        {}\nspdlog       {}.{}.{}\nfmt          {}.{}.{}\n", CLI11_VERSION, SPDLOG_VER_MAJOR,
                  SPDLOG_VER_MINOR, SPDLOG_VER_PATCH, FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100);
  return text;
}

} // namespace kindling::app
