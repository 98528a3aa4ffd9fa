// Denoising of finished images by Intel Open Image Denoise.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/base/result.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

enum class Denoising : uint8_t {
  off,
  fast, // a smaller network; albedo and normal as they are
  best  // the largest network; albedo and normal are denoised first
};
[[nodiscard]] std::string_view denoising_name(Denoising denoising); // "off", "fast", "best"
[[nodiscard]] std::optional<Denoising> denoising_from_name(std::string_view name);

// An image by rows from the top.
struct NoisyImage {
  V2i size_px;
  std::span<const float> rgba;   // four floats per pixel, linear, premultiplied
  std::span<const float> albedo; // three floats per pixel, 0 to 1; empty: none
  std::span<const float> normal; // three floats per pixel, unit or shorter; empty: none
};

class Denoiser {
 public:
  // Opens the library and starts its CPU device with that number of threads; 0: all cores. Fails
  // (render_failed) with how to get the library.
  [[nodiscard]] static Result<Denoiser> open(int threads);

  [[nodiscard]] const std::string& version() const { return version_; } // "2.5.1"

  // Returns the pixels of the denoised image as NoisyImage::rgba. Alpha stays as it is, and pixels
  // of alpha 0 keep their color. Values that are not finite count as 0. `on_progress`, which may
  // be empty, gets fractions from 0 to 1 and cancels with false. Fails (render_failed) if the
  // library does, and if it was cancelled.
  [[nodiscard]] Result<std::vector<float>> denoise(const NoisyImage& image, Denoising quality,
                                                   const std::function<bool(double)>& on_progress) const;

 private:
  struct Started;
  std::shared_ptr<const Started> started_;
  std::string version_;
};

} // namespace kindling
