// An EXR image with what a denoiser needs of it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/denoise/exr_layers.h"
#include "renderer/base/result.h"
#include "renderer/denoise/blend_frames.h"

#include <filesystem>
#include <vector>

namespace kindling::app {

struct DenoisableImage {
  ExrImage image; // each layer has one channel
  DenoisableLayers layers{};
  std::vector<float> rgba;           // noisy
  std::vector<float> albedo, normal; // empty: none
  std::vector<float> motion;         // as NoisyFrame::motion; empty: none
  std::vector<float> samples;        // of each pixel; empty: unknown

  [[nodiscard]] V2i size_px() const { return image.data_max_px - image.data_min_px; }
  [[nodiscard]] NoisyFrame as_frame() const { return {size_px(), rgba, albedo, normal, motion, samples}; }
};

// Fails as read_exr() and find_layers() do.
[[nodiscard]] Result<DenoisableImage> read_denoisable(const std::filesystem::path& file);

} // namespace kindling::app
