// Options of `kindling resume`.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/progress_mode.h"
#include "renderer/denoise/denoising.h"
#include "renderer/device/make_device.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace kindling::app {

// Unset members keep the value of the checkpoint.
struct ResumeOptions {
  std::filesystem::path file;   // .kacc
  std::filesystem::path folder; // start of the render's relative names
  std::filesystem::path scene_file;
  std::optional<uint32_t> spp;
  std::vector<std::filesystem::path> outputs;
  std::filesystem::path stats_file;
  std::optional<Denoising> denoising;
  std::optional<DeviceKind> device;
  std::optional<uint64_t> device_memory_bytes;
  std::optional<int> threads;
  std::optional<double> time_limit_s;
  std::optional<double> checkpoint_every_s;
  std::optional<ProgressMode> progress;
  bool quiet = false;
  bool verbose = false;
};

} // namespace kindling::app
