// The pixels of an image outside of a crop, whose light paths reach it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <algorithm>
#include <cstdint>

namespace kindling {

// A crop shows the light that the light paths of all samples of the image bring to it. Those of the
// pixels outside of it are shared out evenly among the blocks of pixels that it touches: a block
// traces its share with its own samples. So the share of a block depends on the image and its crop
// alone, and each part of the crop has the light paths of its own blocks.
struct OutsidePixels {
  // Numbers of pixels outside, from the first up to the last, which is left out.
  struct Range {
    uint64_t first = 0, end = 0;
    [[nodiscard]] uint64_t count() const { return end - first; }
  };

  [[nodiscard]] uint64_t count() const { return pixels_of(size_px) - pixels_of(crop_end - crop_min); }

  // Returns the index of the pixel with this number, row by row through the whole image.
  [[nodiscard]] uint64_t index_at(uint64_t number) const {
    const auto width = static_cast<uint64_t>(size_px.x);
    const uint64_t above = static_cast<uint64_t>(crop_min.y) * width;
    if (number < above) return number;
    const auto crop_width = static_cast<uint64_t>(crop_end.x - crop_min.x);
    const auto rows = static_cast<uint64_t>(crop_end.y - crop_min.y);
    const uint64_t beside = width - crop_width; // in each row of the crop
    const uint64_t within = number - above;
    if (within >= rows * beside) return number + rows * crop_width;
    const uint64_t column = within % beside;
    return above + within / beside * width + column +
           (column < static_cast<uint64_t>(crop_min.x) ? uint64_t{0} : crop_width);
  }

  // Returns the share of the block that has this pixel of the crop. `side`: of a block, in pixels;
  // blocks lie on a grid through the image's origin.
  [[nodiscard]] Range share_of(const V2i& pixel, int side) const {
    const uint64_t all = count();
    if (all == 0) return {};
    const V2i first(crop_min.x / side, crop_min.y / side);
    const V2i last((crop_end.x - 1) / side, (crop_end.y - 1) / side);
    const auto columns = static_cast<uint64_t>(last.x - first.x + 1);
    const uint64_t blocks = columns * static_cast<uint64_t>(last.y - first.y + 1);
    const uint64_t block =
        static_cast<uint64_t>(pixel.y / side - first.y) * columns + static_cast<uint64_t>(pixel.x / side - first.x);
    const auto before = [&](uint64_t blocks_before) {
      return all / blocks * blocks_before + std::min(all % blocks, blocks_before);
    };
    return {before(block), before(block + 1)};
  }

  V2i size_px{0}; // of the image
  // The crop: the pixels from `crop_min` up to `crop_end`, which is left out.
  V2i crop_min{0}, crop_end{0};

 private:
  [[nodiscard]] static uint64_t pixels_of(const V2i& size) {
    return static_cast<uint64_t>(size.x) * static_cast<uint64_t>(size.y);
  }
};

} // namespace kindling
