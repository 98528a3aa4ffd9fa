// A 2-D texture: texels at their file's bit depth, wrapped, filtered and decoded to linear values on look-up.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/image/image.h"
#include "renderer/image/tiled_cache.h"
#include "renderer/texture/mip_levels.h"
#include "renderer/texture/texture_settings.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <memory>

namespace kindling {

// Immutable, thread-safe, cheap to copy: pixels are shared (one image used as color and as data is held once).
class Texture {
 public:
  // The image is complete: at least one pixel, 1 to 4 channels, byte_count() bytes. `levels` are those of the image; null: it has
  // level 0 alone.
  Texture(std::shared_ptr<const Image> image, const TextureSettings& settings,
          std::shared_ptr<const MipLevels> levels = nullptr);
  // Texels are read from `pages`, of all levels. `format` tells size and type of level 0, its pixels are not looked at.
  Texture(std::shared_ptr<const TiledImage> pages, const Image& format, const TextureSettings& settings,
          const MipLevels& sizes);

  // uv as glTF has it: (0, 0) is the corner of the top-left texel. Non-finite uv reads as (0, 0).
  // Missing channels: L is replicated to RGB; alpha is 1. Integers read as [0, 1]. Texels are decoded before they are
  // filtered. `level` in [0, level_count()); levels above 0 are filtered linearly, whatever the filter of the texture.
  [[nodiscard]] V4f sample(const V2f& uv, int level = 0) const;
  [[nodiscard]] Rgb sample_rgb(const V2f& uv, int level = 0) const;
  // One channel of 0..3, as sample() would give it.
  [[nodiscard]] float sample_channel(const V2f& uv, int channel, int level = 0) const;

  // Asks for the memory that a look-up at uv will read.
  void prefetch(const V2f& uv, int level = 0) const;

  // The level of a look-up for a footprint that covers `uv_area` of the unit square (>= 0; infinite is one texel): one of the two
  // between which its width in texels lies, the coarser one with a probability that grows from 0 to 1 as the logarithm does. `u` in
  // [0, 1) decides. A footprint of no more than a texel of level 0 gets level 0.
  [[nodiscard]] int choose_level(float uv_area, float u) const {
    const float texels = uv_area * texel_count_;
    if (!(texels > 1.0f)) return 0;
    // log2 of the width, by the bits of a float: straight lines between powers of two, at most 0.043 too low.
    const float log2_width = static_cast<float>(std::bit_cast<int32_t>(texels) - (127 << 23)) * 0x1p-24f;
    return std::min(static_cast<int>(log2_width + u), level_count_ - 1);
  }
  [[nodiscard]] int level_count() const { return level_count_; }

  // The mean of sample_rgb() over a triangle in uv space, by a fixed point set about as dense as its texels (16 to
  // 65536 points): for the power of an emissive triangle. The same for the same arguments, always.
  [[nodiscard]] Rgb average_rgb(const V2f& uv0, const V2f& uv1, const V2f& uv2) const;

  [[nodiscard]] V2i size_px() const { return {levels_[0].width, levels_[0].height}; }
  // False: alpha is exactly 1 everywhere, because there is no alpha channel or all of it is opaque.
  [[nodiscard]] bool has_alpha() const { return has_alpha_; }

 private:
  struct Lookup;
  Texture(const Image& format, const TextureSettings& settings);
  struct Level {
    const std::byte* pixels = nullptr; // null: in pages
    int width = 0;
    int height = 0;
  };

  std::shared_ptr<const Image> image_;
  std::shared_ptr<const MipLevels> mip_levels_;
  std::shared_ptr<const TiledImage> pages_; // where the levels have no pixels
  float texel_count_;                       // of level 0
  int level_count_ = 1;
  uint8_t layout_;      // make_layout() of texel_fetch.h: which code reads a texel
  uint8_t pixel_bytes_; // of one texel
  TextureWrap wrap_u_;
  TextureWrap wrap_v_;
  TextureFilter filter_;
  bool repeats_; // both axes: the common case, on a path of its own
  bool has_alpha_;
  std::array<Level, kMaxMipLevels> levels_;
};

} // namespace kindling
