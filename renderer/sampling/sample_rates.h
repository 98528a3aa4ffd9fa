// SampleRates: how the samples of a render are divided among its pixels.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/sampling/sample_range.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace kindling {

enum class SampleRateKind : uint8_t {
  even,      // all pixels have the same samples
  noise,     // pixels have more samples where there is more noise (allocate_samples.h)
  automatic, // noise where that pays off and works with the other settings, else even
};
[[nodiscard]] std::string_view sample_rates_name(SampleRateKind kind); // "even", "noise", "auto"
[[nodiscard]] std::optional<SampleRateKind> sample_rates_from_name(std::string_view name);

// With rates a render counts levels in place of samples: as many levels as a render without them
// has samples of a pixel. The first levels are one sample of every pixel each, the pilot. From then
// on a pixel takes groups of samples, spread over the levels, so that it has a number of its own at
// the last of the planned levels: a power of two, which fills the plane evenly. Everything that
// counts the samples of blocks (passes, coverage, parts) counts levels.
class SampleRates {
 public:
  static constexpr uint32_t kPilotLevels = 4;
  static constexpr uint32_t kGroup = 4;               // samples that a pixel takes together
  static constexpr uint32_t kMaxAtLevel = 2 * kGroup; // samples of a pixel
  // A pixel has planned / 2^kMinLog2Ratio to planned * 2^kMaxLog2Ratio samples.
  static constexpr uint32_t kMinLog2Ratio = 3, kMaxLog2Ratio = 2;

  // Returns the logarithms of the least and of the largest number of samples of a pixel. planned:
  // levels, more than those of the pilot.
  [[nodiscard]] static uint32_t min_log2(uint32_t planned) {
    return std::max(ceil_log2(planned), 2 + kMinLog2Ratio) - kMinLog2Ratio;
  }
  [[nodiscard]] static uint32_t max_log2(uint32_t planned) {
    const uint64_t at_levels = kPilotLevels + uint64_t{planned - kPilotLevels} * kMaxAtLevel;
    const uint64_t samples = std::min({uint64_t{planned} << kMaxLog2Ratio, at_levels, uint64_t{1} << 31});
    return static_cast<uint32_t>(std::bit_width(samples)) - 1;
  }

  // `log2_samples`: of the pixels of a rectangle at the planned level, rows from the top, each from
  // min_log2() to max_log2().
  SampleRates(const V2i& corner, int width, uint32_t planned, std::vector<uint8_t> log2_samples)
      : corner_(corner), width_(width), planned_(planned), log2_samples_(std::move(log2_samples)) {
    assert(width > 0 && log2_samples_.size() % static_cast<size_t>(width) == 0);
    assert(planned > kPilotLevels);
  }

  // Returns the number of samples that a pixel of the rectangle has before `level`. Levels beyond
  // the planned ones take as many samples as those did.
  [[nodiscard]] uint32_t samples_before(const V2i& pixel, uint32_t level) const {
    if (level <= kPilotLevels) return level;
    const uint64_t levels = level - kPilotLevels, round = planned_ - kPilotLevels;
    const uint64_t groups = (planned_samples(pixel) - kPilotLevels) / kGroup; // of a round
    const uint64_t begun = (levels % round * groups + ((kOffsets[offset_index(pixel)] * round) >> 4)) / round;
    const uint64_t samples = kPilotLevels + (levels / round * groups + begun) * kGroup;
    return static_cast<uint32_t>(std::min(samples, uint64_t{UINT32_MAX}));
  }
  // Returns the samples that it takes at these levels.
  [[nodiscard]] SampleRange samples_at(const V2i& pixel, const SampleRange& levels) const {
    return {samples_before(pixel, levels.first), samples_before(pixel, levels.end)};
  }
  // Returns the number of its samples before the planned level.
  [[nodiscard]] uint32_t planned_samples(const V2i& pixel) const {
    assert(pixel.x >= corner_.x && pixel.x < corner_.x + width_ && pixel.y >= corner_.y);
    const size_t index = static_cast<size_t>(pixel.y - corner_.y) * static_cast<size_t>(width_) +
                         static_cast<size_t>(pixel.x - corner_.x);
    assert(index < log2_samples_.size());
    return 1U << log2_samples_[index];
  }

 private:
  [[nodiscard]] static uint32_t ceil_log2(uint32_t planned) {
    return static_cast<uint32_t>(std::bit_width(planned - 1));
  }
  // Fractions of groups, in sixteenths: an ordered dither (Bayer 1973), so that the pixels of a
  // block do not all wait for the same level.
  static constexpr std::array<uint8_t, 16> kOffsets{0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5};
  [[nodiscard]] static size_t offset_index(const V2i& pixel) {
    return static_cast<size_t>(pixel.y & 3) * 4 + static_cast<size_t>(pixel.x & 3);
  }

  V2i corner_;
  int width_;
  uint32_t planned_;
  std::vector<uint8_t> log2_samples_;
};

} // namespace kindling
