// Lists the samples that the pixels of a block take at levels.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/camera_stage.h"
#include "renderer/sampling/sample_rates.h"

#include <array>
#include <cassert>
#include <cstdint>
#include <vector>

namespace kindling {

// Goes through the levels of a block, a batch at a time.
class LevelList {
 public:
  // Most samples of a block at one level.
  static constexpr uint32_t kMaxOfLevel = kBlockSize * kBlockSize * SampleRates::kMaxAtLevel;

  // `rates` must outlive this and have the pixels of `block`.
  LevelList(const PixelRect& block, const SampleRates& rates, uint32_t first_level)
      : block_(block), rates_(rates), level_(first_level) {
    assert(block.width() <= kBlockSize && block.height() <= kBlockSize);
    for_each_pixel(
        [&](size_t i, const V2i& pixel, uint8_t, uint8_t) { done_[i] = rates_.samples_before(pixel, level_); });
    look_ahead();
  }

  // The next level.
  [[nodiscard]] uint32_t level() const { return level_; }

  // Replaces `list` by the samples of as many levels as are before `end` and fit into
  // `max_samples`, at least one level: level by level, the first samples of all pixels before the
  // second ones. max_samples: at least kMaxOfLevel.
  void take(uint32_t end, size_t max_samples, std::vector<BlockSample>& list) {
    assert(level_ < end && max_samples >= kMaxOfLevel);
    list.clear();
    do {
      for (uint32_t round = 0; round < rounds_; ++round)
        for_each_pixel([&](size_t i, const V2i&, uint8_t x, uint8_t y) {
          if (done_[i] + round < next_[i]) list.push_back({x, y, done_[i] + round});
        });
      done_ = next_;
      ++level_;
      look_ahead();
    } while (level_ < end && list.size() + count_ <= max_samples);
  }

 private:
  template <typename Action>
  void for_each_pixel(const Action& action) const {
    size_t i = 0;
    for (int y = 0; y < block_.height(); ++y)
      for (int x = 0; x < block_.width(); ++x, ++i)
        action(i, block_.min + V2i(x, y), static_cast<uint8_t>(x), static_cast<uint8_t>(y));
  }

  void look_ahead() {
    rounds_ = 0;
    count_ = 0;
    for_each_pixel([&](size_t i, const V2i& pixel, uint8_t, uint8_t) {
      next_[i] = rates_.samples_before(pixel, level_ + 1);
      rounds_ = std::max(rounds_, next_[i] - done_[i]);
      count_ += next_[i] - done_[i];
    });
  }

  PixelRect block_;
  const SampleRates& rates_;
  uint32_t level_;
  std::array<uint32_t, kBlockSize * kBlockSize> done_{}; // samples of the pixels before the level
  std::array<uint32_t, kBlockSize * kBlockSize> next_{}; // and after it
  uint32_t rounds_ = 0;                                  // most samples of a pixel at the level
  uint32_t count_ = 0;                                   // samples of all pixels at the level
};

} // namespace kindling
