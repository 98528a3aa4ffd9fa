// SampleRates: how the samples of a render are divided among its pixels.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/sampling/sample_range.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace kindling {

enum class SampleRateKind : uint8_t {
  even,  // all pixels have the same samples
  noise, // pixels have more samples where there is more noise (allocate_samples.h)
};
[[nodiscard]] std::string_view sample_rates_name(SampleRateKind kind); // "even", "noise"
[[nodiscard]] std::optional<SampleRateKind> sample_rates_from_name(std::string_view name);

// With rates a render counts levels in place of samples: as many levels as a render without them
// has samples of a pixel. The first levels are one sample of every pixel each, the pilot. At every
// later level a pixel takes its rate of samples, on average: three samples, or one at every fourth
// level; it takes them in groups, which fill the plane better than odd numbers of samples.
// Everything that counts the samples of blocks (passes, coverage, parts) counts levels.
class SampleRates {
 public:
  static constexpr uint32_t kPilotLevels = 4;
  static constexpr uint32_t kGroup = 4;           // samples that a pixel takes together
  static constexpr uint32_t kUnit = 16;           // one sample at each level
  static constexpr uint32_t kMinRate = kUnit / 8; // in 1 / kUnit
  static constexpr uint32_t kMaxRate = kUnit * 4;

  // `rates`: of the pixels of a rectangle, rows from the top, each kMinRate to kMaxRate.
  SampleRates(const V2i& corner, int width, std::vector<uint8_t> rates)
      : corner_(corner), width_(width), rates_(std::move(rates)) {
    assert(width > 0 && rates_.size() % static_cast<size_t>(width) == 0);
  }

  // Returns the number of samples that a pixel of the rectangle has before `level`.
  [[nodiscard]] uint32_t samples_before(const V2i& pixel, uint32_t level) const {
    if (level <= kPilotLevels) return level;
    constexpr uint32_t kPerGroup = kUnit * kGroup;
    const uint64_t due = uint64_t{level - kPilotLevels} * rate(pixel) + kOffsets[offset_index(pixel)] * kPerGroup / 16;
    return kPilotLevels + static_cast<uint32_t>(due / kPerGroup) * kGroup;
  }
  // Returns the samples that it takes at these levels.
  [[nodiscard]] SampleRange samples_at(const V2i& pixel, const SampleRange& levels) const {
    return {samples_before(pixel, levels.first), samples_before(pixel, levels.end)};
  }
  [[nodiscard]] uint32_t rate(const V2i& pixel) const {
    assert(pixel.x >= corner_.x && pixel.x < corner_.x + width_ && pixel.y >= corner_.y);
    const size_t index = static_cast<size_t>(pixel.y - corner_.y) * static_cast<size_t>(width_) +
                         static_cast<size_t>(pixel.x - corner_.x);
    assert(index < rates_.size());
    return rates_[index];
  }

 private:
  // Fractions of samples, in 1 / kUnit: an ordered dither (Bayer 1973), so that the pixels of a
  // block do not all wait for the same level.
  static constexpr std::array<uint8_t, 16> kOffsets{0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5};
  [[nodiscard]] static size_t offset_index(const V2i& pixel) {
    return static_cast<size_t>(pixel.y & 3) * 4 + static_cast<size_t>(pixel.x & 3);
  }

  V2i corner_;
  int width_;
  std::vector<uint8_t> rates_;
};

} // namespace kindling
