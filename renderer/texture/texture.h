// 2-D texture: texels at the bit depth of their file, decoded and filtered on look-up.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/image/image.h"
#include "renderer/image/tiled_cache.h"
#include "renderer/texture/mip_levels.h"
#include "renderer/texture/texture_settings.h"
#include "renderer/texture/texture_tiles.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstdint>
#include <memory>
#include <span>

namespace kindling {

// A texture as look-ups read it. Its texels are in memory, or in pages that a cache loads, or on a
// device level by level in memory or in tiles.
struct TextureView {
  // Returns the filtered texel at uv, as in glTF: (0, 0) is the corner of the top-left texel.
  // Non-finite uv counts as (0, 0). Luminance is replicated to RGB; missing alpha is 1. Integers
  // map to [0, 1]. Texels are decoded before they are filtered. `level` is in [0, level_count());
  // levels above 0 are always filtered linearly.
  [[nodiscard]] V4f sample(const V2f& uv, int level = 0) const;
  [[nodiscard]] Rgb sample_rgb(const V2f& uv, int level = 0) const;
  // Returns one channel (0 to 3) of sample().
  [[nodiscard]] float sample_channel(const V2f& uv, int channel, int level = 0) const;

  // Writes alpha of all texels in a row of level 0, as sample_channel() returns it where it reads
  // one texel alone. The level must have pixels.
  void alphas_of_row(int row, std::span<float> alphas) const;

  // Prefetches the memory that a look-up at uv reads.
  void prefetch(const V2f& uv, int level = 0) const;

  // Returns a level for a footprint that covers `uv_area` of the unit square (>= 0; infinity
  // selects the last level). It is one of the two levels whose texel widths enclose that of the
  // footprint, chosen by `u` in [0, 1): the probability of the coarser one grows from 0 to 1 with
  // the logarithm of the width. Footprints of at most one texel of level 0 get level 0.
  [[nodiscard]] int choose_level(float uv_area, float u) const {
    assert(!(uv_area < 0.0f) && u >= 0.0f && u < 1.0f);
    const float texels = uv_area * texel_count;
    if (!(texels > 1.0f)) return 0;
    // log2 of the width from the bits of a float: linear between powers of two, at most 0.043 too
    // low.
    const float log2_width = static_cast<float>(std::bit_cast<int32_t>(texels) - (127 << 23)) * 0x1p-24f;
    return std::min(static_cast<int>(log2_width + u), level_count - 1);
  }

  [[nodiscard]] V2i size_px() const { return {levels[0].width, levels[0].height}; }
  // Copies texels of a level from `tiles` or `pages`, as TiledImage::fetch() does.
  void fetch(int level, const std::array<int, 2>& x, const std::array<int, 2>& y, std::byte* texels) const;

  struct Level {
    const std::byte* pixels = nullptr; // null if the texels are in pages or tiles
    int width = 0;
    int height = 0;
  };

  const TiledImage* pages = nullptr;   // set if the levels have no pixels
  const TextureTiles* tiles = nullptr; // on a device, set if some levels have none
  float texel_count = 1.0f;            // of level 0
  int level_count = 1;
  uint8_t layout = 0;      // of a texel, from make_layout() of texel_fetch.h
  uint8_t pixel_bytes = 0; // bytes of one texel
  TextureWrap wrap_u = TextureWrap::repeat;
  TextureWrap wrap_v = TextureWrap::repeat;
  TextureFilter filter = TextureFilter::linear;
  bool repeats = true;    // true if both axes repeat, the common case with a faster path
  bool has_alpha = false; // false if alpha is exactly 1 everywhere: no alpha channel, or an opaque one
  std::array<Level, kMaxMipLevels> levels;
};

// An immutable, thread-safe texture that is cheap to copy: textures share the pixels of an image
// (one that is used as color and as data is stored once).
class Texture : public TextureView {
 public:
  // The image must be complete: at least one pixel, 1 to 4 channels, byte_count() bytes. `mips`
  // are the levels of the image; without them the texture has level 0 only.
  Texture(std::shared_ptr<const Image> image, const TextureSettings& settings,
          std::shared_ptr<const MipLevels> mips = nullptr);
  // Reads the texels of all levels from `tiled`. `format` gives the size and type of level 0; its
  // pixels are ignored.
  Texture(std::shared_ptr<const TiledImage> tiled, const Image& format, const TextureSettings& settings,
          const MipLevels& sizes);

 private:
  Texture(const Image& format, const TextureSettings& settings);

  std::shared_ptr<const Image> image_;
  std::shared_ptr<const MipLevels> mip_levels_;
  std::shared_ptr<const TiledImage> tiles_;
};

} // namespace kindling
