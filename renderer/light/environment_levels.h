// Means of an environment over wide areas: a pyramid of small images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/elementary.h"
#include "renderer/base/math.h"
#include "renderer/light/fp16_texels.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace kindling {

// Level 0 is the finest. Each level is half as wide and half as high as the one before, down to 8 x
// 4 texels, and has a border of a texel as EnvironmentView::texels, whose radiances it averages by
// solid angle. Levels are small: footprints that they are too coarse for read the environment's
// own texels.
struct EnvironmentLevels {
  static constexpr int kMaxWidth = 512, kMinWidth = 8;

  // Returns how many levels there are; 0 if the image is less than twice as wide as the coarsest.
  [[nodiscard]] int count() const {
    int levels = 0;
    for (int w = width; w >= kMinWidth; w /= 2) ++levels;
    return levels;
  }
  // Returns the level for an area that is `width_turns` wide, in full turns; its fraction is the
  // weight of the level beyond. Up to -1 the environment's own texels are fine enough.
  [[nodiscard]] float level_of(float width_turns) const {
    const float in_texels = width_turns * static_cast<float>(width);
    return in_texels > 0.5f ? std::min(elementary::log2(in_texels), static_cast<float>(count() - 1)) : -1.0f;
  }
  // Returns the interpolated texels of a level at image coordinates in [0, 1].
  [[nodiscard]] Rgb at(int level, float u, float v) const {
    const Fp16Texel* first = texels.data();
    int w = width;
    for (; level > 0; --level, w /= 2) first += texels_of_level(w);
    const float x = std::min(1.0f, u) * static_cast<float>(w) + 0.5f;
    const float y = std::min(1.0f, v) * static_cast<float>(w / 2) + 0.5f;
    const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
    const size_t stride = static_cast<size_t>(w) + 2;
    const Fp16Texel* const top = first + static_cast<size_t>(y0) * stride + static_cast<size_t>(x0);
    const V4f value = interpolate(top, top + stride, x - static_cast<float>(x0), y - static_cast<float>(y0));
    return {value.x, value.y, value.z};
  }

  // Returns the number of texels of a level with its border.
  [[nodiscard]] static size_t texels_of_level(int width) {
    return (static_cast<size_t>(width) + 2) * (static_cast<size_t>(width / 2) + 2);
  }

  int width = 0;                     // of level 0, a power of two, twice its height; 0: no levels
  std::span<const Fp16Texel> texels; // of all levels, the finest first; `weight` is 0
};

// Returns the texels of all levels of an equirectangular image, whose level 0 is `level_width`
// wide. `texels` have a border, as EnvironmentView::texels.
[[nodiscard]] std::vector<Fp16Texel> make_environment_levels(std::span<const Fp16Texel> texels, int width, int height,
                                                             int level_width);

} // namespace kindling
