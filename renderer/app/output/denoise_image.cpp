// Runs the denoiser; measures it on a small image.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/output/denoise_image.h"

#include "renderer/app/setup/available_memory.h"
#include "renderer/app/terminal/stopwatch.h"

#include <fmt/format.h>

#include <algorithm>

namespace kindling::app {

namespace {

// Half of what is available, so that the system keeps its caches; less would be slow.
uint64_t scratch_bytes() {
  constexpr uint64_t kMinScratchBytes = 256U << 20;
  const std::optional<uint64_t> available = available_memory_bytes();
  return available ? std::clamp(*available / 2, kMinScratchBytes, kMaxDenoiseScratchBytes) : kMaxDenoiseScratchBytes;
}

} // namespace

Result<std::optional<DenoisedImage>> denoise_image(const NoisyImage& image, Denoising quality, int threads,
                                                   ProgressDisplay& display, const CancelToken* cancel) {
  const Result<Denoiser> denoiser = Denoiser::open(threads);
  if (!denoiser.ok()) return denoiser.error();
  const bool cancelled_before = cancel != nullptr && cancel->cancelled();
  const auto cancelled = [&] { return cancel != nullptr && !cancelled_before && cancel->cancelled(); };
  display.start_phase(Phase::denoise);
  Result<std::vector<float>> denoised = denoiser.value().denoise(
      image, quality,
      [&](double fraction) {
        display.on_progress({.phase = Phase::denoise, .done = fraction, .total = 1.0});
        return !cancelled();
      },
      scratch_bytes());
  display.end_phase();
  if (!denoised.ok() && cancelled()) return std::optional<DenoisedImage>();
  if (!denoised.ok()) return denoised.error();
  return std::optional(
      DenoisedImage{std::move(denoised).value(),
                    fmt::format("Open Image Denoise {}, {}", denoiser.value().version(), denoising_name(quality))});
}

double predict_denoise_s(const V2i& size_px, Denoising quality, int threads) {
  constexpr int kSide = 160;
  const Result<Denoiser> denoiser = Denoiser::open(threads);
  if (!denoiser.ok()) return 0.0;
  const size_t pixels = size_t{kSide} * kSide;
  const std::vector<float> rgba(4 * pixels, 0.5f), guide(3 * pixels, 0.5f);
  const NoisyImage small{V2i(kSide), rgba, guide, guide};
  (void)denoiser.value().denoise(small, quality, nullptr); // loads the weights
  const Clock::time_point start = Clock::now();
  if (!denoiser.value().denoise(small, quality, nullptr).ok()) return 0.0;
  const double share = static_cast<double>(size_px.x) * static_cast<double>(size_px.y) / static_cast<double>(pixels);
  return seconds_since(start) * std::max(share, 1.0);
}

} // namespace kindling::app
