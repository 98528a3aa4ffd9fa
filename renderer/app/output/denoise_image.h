// Denoising with progress, cancelled by the first signal, within the memory that is available.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/terminal/progress_display.h"
#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/denoise/denoiser.h"

#include <optional>
#include <string>
#include <vector>

namespace kindling::app {

struct DenoisedImage {
  std::vector<float> rgba; // as NoisyImage::rgba
  std::string by;          // "Open Image Denoise 2.5.1, best"
};

// Denoises an image. Reports Phase::denoise. Returns nothing if `cancel`, which may be null, was
// cancelled meanwhile; a render that was cancelled before is denoised all the same. Fails as
// Denoiser does.
[[nodiscard]] Result<std::optional<DenoisedImage>> denoise_image(const NoisyImage& image, Denoising quality,
                                                                 int threads, ProgressDisplay& display,
                                                                 const CancelToken* cancel);

// Predicts the seconds that denoising an image with albedo and normal takes on this machine, by a
// small one. 0 if the library fails.
[[nodiscard]] double predict_denoise_s(const V2i& size_px, Denoising quality, int threads);

} // namespace kindling::app
