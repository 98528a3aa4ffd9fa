// Smaller versions of an image, each texel the mean of what it covers.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/image/image.h"
#include "renderer/texture/srgb.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace kindling {

// What texels stand for: decides how they are averaged, and how their integers become linear values.
enum class TextureContent : uint8_t {
  data,           // linear values: plain means
  color,          // sRGB, averaged as light; alpha is linear and averaged apart
  cutout_color,   // the same, weighted by alpha: what a material with coverage shows where it covers
  tangent_normal, // 2 rgb - 1 is a direction: the mean of unit vectors, which is shorter the more they differ
};

// Level 0 is the image itself and not held here. Level l + 1 has half the width and height of level l, rounded down, at least 1;
// the last is one texel.
struct MipLevels {
  struct Level {
    int width = 0;
    int height = 0;
    size_t offset = 0; // into `pixels`
  };
  std::vector<Level> levels;     // 1 and up
  std::vector<std::byte> pixels; // of the image's type and channels, laid out as Image
  bool opaque = true;            // of the image: alpha is 1 everywhere, or absent
};

inline constexpr int kMaxMipLevels = 16; // with level 0: a side has at most 32768 pixels

// A row of the image, valid until the next call.
using ReadRow = std::function<const std::byte*(int row)>;

// Exact box filter: where a size is odd, texels of the next level share the texels between them (Guthe and Heckbert 2005,
// "Non-Power-of-Two Mipmapping"). Sums are of floats, all levels from the unrounded one before; a level is rounded to the type of
// the image when it is stored. One pass over the rows, with a few rows of floats as memory. The result depends on
// the arguments alone.
[[nodiscard]] MipLevels build_mip_levels(const Image& format, TextureContent content, const ReadRow& read_row);
// The same of an image in memory.
[[nodiscard]] MipLevels build_mip_levels(const Image& image, TextureContent content);

} // namespace kindling
