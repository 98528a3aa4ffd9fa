// Decisions at powers of two.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/adaptive_sampling.h"

#include <algorithm>
#include <bit>

namespace kindling {

AdaptiveSampling::AdaptiveSampling(const PixelRect& crop, const AdaptiveSettings& settings)
    : crop_(crop), noise_threshold_(settings.noise_threshold),
      first_decision_(std::bit_ceil((settings.min_samples_per_pixel + 1) / 2)),
      stop_at_(settings.enabled() ? static_cast<size_t>(crop.pixel_count()) : 0, kUndecided) {}

uint32_t AdaptiveSampling::samples_to_decision(uint32_t done) const {
  return std::max(first_decision_, std::bit_floor(done) * 2) - done;
}

PixelBlock AdaptiveSampling::remaining(const PixelRect& block, uint32_t done) const {
  PixelBlock left(block);
  for (int y = block.min.y; y < block.max.y; ++y)
    for (int x = block.min.x; x < block.max.x; ++x)
      if (stop_at_[index_of(x, y)] <= done) left.skipped |= PixelBlock::bit_of(x - block.min.x, y - block.min.y);
  return left;
}

uint32_t AdaptiveSampling::decide(const PixelRect& block, uint32_t done, const Film& film) {
  if (done < first_decision_ || !std::has_single_bit(done) || done > kUndecided / 4) return 0;
  uint32_t stopped = 0;
  for (int y = block.min.y; y < block.max.y; ++y)
    for (int x = block.min.x; x < block.max.x; ++x) {
      uint32_t& stop_at = stop_at_[index_of(x, y)];
      if (stop_at == done) ++stopped;
      if (stop_at != kUndecided) continue;
      if (film.relative_error(V2i(x, y), 2 * done) < noise_threshold_) stop_at = 2 * done;
    }
  return stopped;
}

} // namespace kindling
