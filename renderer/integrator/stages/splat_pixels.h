// The pixels that a splat reaches through the pixel filter.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/sampling/pixel_filter.h"

#include <algorithm>
#include <cmath>

namespace kindling {

// Calls visit(pixel, weight) for the pixels from `min` up to `end`, which is left out, in whose
// filter a position of the image lies.
template <typename Visit>
inline void visit_splat_pixels(const PixelFilter& filter, const V2f& film_px, const V2i& min, const V2i& end,
                               const Visit& visit) {
  const float radius = 0.5f * filter.width();
  const auto first = [&](float x, int lower) {
    return std::max(static_cast<int>(std::ceil(x - radius - 0.5f)), lower);
  };
  const auto last = [&](float x, int upper) {
    return std::min(static_cast<int>(std::floor(x + radius - 0.5f)) + 1, upper);
  };
  for (int y = first(film_px.y, min.y); y < last(film_px.y, end.y); ++y)
    for (int x = first(film_px.x, min.x); x < last(film_px.x, end.x); ++x) {
      const float weight =
          filter.value({film_px.x - 0.5f - static_cast<float>(x), film_px.y - 0.5f - static_cast<float>(y)});
      if (weight != 0.0f) visit(V2i(x, y), weight);
    }
}

} // namespace kindling
