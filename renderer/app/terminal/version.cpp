// Lists the versions of this program and of the libraries that it was built with.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/terminal/version.h"

#include "accel/make_accelerator.h"
#include "renderer/denoise/denoiser.h"
#include "renderer/image/library_versions.h"

#include <CLI/Version.hpp>
#include <fmt/format.h>

#include <spdlog/version.h>
#include <tbb/version.h>

namespace kindling::app {

std::string version_text() {
  std::string text = fmt::format("kindling {}\n", version());
  text += fmt::format("sources      {}\ncompiler     {}, {}\n", sources_hash(), compiler(), build_type());
  text += "accelerators";
  for (const accel::Kind kind : {accel::Kind::embree, accel::Kind::kdtree, accel::Kind::brute_force})
    text += fmt::format("{} {} ({})", kind == accel::Kind::embree ? "" : ",", accel::kind_name(kind),
                        accel::kind_description(kind));
  text += fmt::format("\noneTBB       {}\n", TBB_runtime_version());
  for (const auto& [name, number] : image_library_versions()) text += fmt::format("{:<12} {}\n", name, number);
  const Result<Denoiser> denoiser = Denoiser::open(1);
  text += fmt::format("OIDN         {}\n", denoiser.ok()
                                               ? denoiser.value().version()
                                               : fmt::format("none ({} installs it)", denoiser_install_command()));
  text +=
      fmt::format("CLI11        {}\nspdlog       {}.{}.{}\nfmt          {}.{}.{}\n", CLI11_VERSION, SPDLOG_VER_MAJOR,
                  SPDLOG_VER_MINOR, SPDLOG_VER_PATCH, FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100);
  return text;
}

} // namespace kindling::app
