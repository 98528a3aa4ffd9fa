// Mip levels of an image: each texel is the mean of the area that it covers.
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

// The meaning of texels; determines how they are averaged and how integers are decoded.
enum class TextureContent : uint8_t {
  data,           // linear values; plain means
  color,          // sRGB, averaged as linear values; alpha is linear and averaged separately
  cutout_color,   // like color, weighted by alpha, for materials with coverage
  tangent_normal, // directions 2 rgb - 1; means of unit vectors, which are shorter the more they differ
};

// The levels of an image except for level 0, which is the image itself. Level l + 1 has half the
// width and height of level l, rounded down but at least 1; the last level is one texel.
struct MipLevels {
  struct Level {
    int width = 0;
    int height = 0;
    size_t offset = 0; // into `pixels`
  };
  std::vector<Level> levels;     // levels 1 and up
  std::vector<std::byte> pixels; // type, channels and layout are those of the image
  bool opaque = true;            // true if the alpha of the image is 1 everywhere or absent
};

inline constexpr int kMaxMipLevels = 16; // including level 0; a side has at most 32768 pixels

// Returns a row of the image, valid until the next call.
using ReadRow = std::function<const std::byte*(int row)>;

// Builds all levels by an exact box filter. If a size is odd, texels of the next level share texels
// (Guthe and Heckbert 2005, "Non-Power-of-Two Mipmapping"). Levels are computed in floats from the
// unrounded previous level and rounded to the type of the image when stored, in one pass over the
// rows with a few rows of floats as memory. The result depends on the arguments only.
[[nodiscard]] MipLevels build_mip_levels(const Image& format, TextureContent content, const ReadRow& read_row);
// Builds the levels of an image in memory.
[[nodiscard]] MipLevels build_mip_levels(const Image& image, TextureContent content);

} // namespace kindling
