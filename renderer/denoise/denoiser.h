// Denoising of finished images by Intel Open Image Denoise.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/base/result.h"
#include "renderer/denoise/denoising.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace kindling {

// Returns the command that installs the library: the script of an installed Kindling, or that of
// its source folder.
[[nodiscard]] std::string denoiser_install_command();

// Most scratch memory of a filter: images that would need more are filtered in tiles, which overlap
// by as much as a pixel sees of its surroundings, so that the result is the same.
inline constexpr uint64_t kMaxDenoiseScratchBytes = 2ULL << 30;

// Returns an upper bound of the memory that denoise() takes beside the image that it is given.
[[nodiscard]] uint64_t denoise_memory_bytes(const V2i& size_px, Denoising quality,
                                            uint64_t max_scratch_bytes = kMaxDenoiseScratchBytes);

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
  // of alpha 0 keep their color. A value that is not finite counts as the mean of its neighbors
  // that are, or as 0; without alpha it becomes 0. `on_progress`, which may be empty, gets
  // fractions from 0 to 1 and cancels with false. Fails (render_failed) if the library does, and if
  // it was cancelled.
  [[nodiscard]] Result<std::vector<float>> denoise(const NoisyImage& image, Denoising quality,
                                                   const std::function<bool(double)>& on_progress,
                                                   uint64_t max_scratch_bytes = kMaxDenoiseScratchBytes) const;

 private:
  struct Started;
  std::shared_ptr<const Started> started_;
  std::string version_;
};

} // namespace kindling
