// Estimates the error of blocks at powers of two and decides.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/adaptive_sampling.h"

#include "renderer/session/tile_scheduler.h"

#include <algorithm>
#include <bit>

namespace kindling {
namespace {

int blocks_across(int pixels) { return (pixels + kBlockSize - 1) / kBlockSize; }

} // namespace

bool AdaptiveState::fits(const PixelRect& area) const {
  return stop_at.size() == count_blocks(area) && rays.size() == stop_at.size() &&
         earlier.size() == static_cast<size_t>(area.pixel_count());
}

AdaptiveSampling::AdaptiveSampling(const PixelRect& area, const AdaptiveSettings& settings, AdaptiveState& state)
    : area_(area), noise_threshold_(settings.noise_threshold),
      first_decision_(std::bit_ceil((settings.min_samples_per_pixel + 1) / 2)), state_(state) {
  if (!settings.enabled() || !state_.empty()) return;
  state_.stop_at.assign(count_blocks(area), kUndecided);
  state_.rays.assign(state_.stop_at.size(), 0);
  state_.earlier.assign(static_cast<size_t>(area.pixel_count()), {});
}

PixelRect AdaptiveSampling::whole_blocks(const PixelRect& crop, const V2i& image_size_px) {
  const auto up = [](int pixels) { return blocks_across(pixels) * kBlockSize; };
  return {V2i(crop.min.x / kBlockSize * kBlockSize, crop.min.y / kBlockSize * kBlockSize),
          V2i(std::min(up(crop.max.x), image_size_px.x), std::min(up(crop.max.y), image_size_px.y))};
}

uint32_t AdaptiveSampling::samples_to_decision(uint32_t done) const {
  return std::max(first_decision_ / 2, std::bit_floor(done) * 2) - done;
}

size_t AdaptiveSampling::block_index(const PixelRect& block) const {
  const V2i at((block.min.x - area_.min.x) / kBlockSize, (block.min.y - area_.min.y) / kBlockSize);
  return static_cast<size_t>(at.y) * static_cast<size_t>(blocks_across(area_.width())) + static_cast<size_t>(at.x);
}

size_t AdaptiveSampling::pixel_index(int x, int y) const {
  return static_cast<size_t>(y - area_.min.y) * static_cast<size_t>(area_.width()) +
         static_cast<size_t>(x - area_.min.x);
}

double AdaptiveSampling::squared_error(const PixelRect& block, const Film& film) const {
  double sum = 0.0;
  for (int y = block.min.y; y < block.max.y; ++y)
    for (int x = block.min.x; x < block.max.x; ++x) {
      const Film::Totals all = film.totals(V2i(x, y));
      const Film::Totals& first = state_.earlier[pixel_index(x, y)];
      const double second_weight = all.weight - first.weight;
      // Negative filter lobes outweigh the few samples, or no sample was finite.
      if (!(first.weight > 0.0 && second_weight > 0.0)) return std::numeric_limits<double>::infinity();
      double largest = 0.0;
      for (size_t c = 0; c < 3; ++c) {
        const double difference = first.rgb[c] / first.weight - (all.rgb[c] - first.rgb[c]) / second_weight;
        largest = std::max(largest, difference * difference * 0.25);
      }
      const double scale = std::max(all.luminance() / all.weight, 0.0) + kNoiseFloor;
      sum += largest / (scale * scale);
    }
  return sum / static_cast<double>(block.pixel_count());
}

uint32_t AdaptiveSampling::decide(const PixelRect& block, uint32_t done, const Film& film) {
  if (done < first_decision_ / 2 || !std::has_single_bit(done) || done > kUndecided / 4) return 0;
  uint32_t& stop_at = state_.stop_at[block_index(block)];
  if (stop_at == done) return static_cast<uint32_t>(block.pixel_count());
  if (stop_at != kUndecided) return 0;
  const uint32_t end = 2 * done;
  if (done >= first_decision_) {
    const double error_at_end = 0.5 * squared_error(block, film);
    const double samples = static_cast<double>(block.pixel_count()) * done;
    const double rays_per_sample = static_cast<double>(state_.rays[block_index(block)]) / samples;
    const double bound = noise_threshold_ * noise_threshold_ * (static_cast<double>(end) / kReferenceSamples) *
                         (rays_per_sample / kReferenceRays);
    if (error_at_end < bound) stop_at = end;
  }
  for (int y = block.min.y; y < block.max.y; ++y)
    for (int x = block.min.x; x < block.max.x; ++x) state_.earlier[pixel_index(x, y)] = film.totals(V2i(x, y));
  return 0;
}

} // namespace kindling
