// Classes of texels by an alpha test that no filter can change.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"
#include "renderer/texture/texture.h"
#include "renderer/world/opacity/opacity_micromaps.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace kindling {

// The test of a material with a texture: of `factor` times its alpha. MASK shows what is at least
// `cutoff`; BLEND what is 1, hides what is 0, and decides by chance in between.
struct AlphaTest {
  AlphaMode mode = AlphaMode::mask;
  float factor = 1.0f;
  float cutoff = 0.5f;
  auto operator<=>(const AlphaTest&) const = default;
};

// Two bits for each texel of level 0. Texels so close to the cutoff that rounding may decide are
// mixed.
class AlphaClasses {
 public:
  // The texels must be in memory, not in pages. Parallel with TBB.
  AlphaClasses(const TextureView& texture, const AlphaTest& test);

  // Returns the Opacity that all texels of a row have in common, from column x0 to column x1 before
  // wrapping; mixed if they have none in common. Runs of two widths or more count as whole rows.
  [[nodiscard]] Opacity of_row(int64_t y, int64_t x0, int64_t x1) const;

  [[nodiscard]] V2i size_px() const { return {width_, height_}; }
  // Returns the memory of the classes of an image.
  [[nodiscard]] static uint64_t bytes(int width, int height) {
    return 2 * row_words(width) * static_cast<uint64_t>(height) * sizeof(uint64_t);
  }

 private:
  [[nodiscard]] static size_t row_words(int width) { return (static_cast<size_t>(width) + 63) / 64; }
  // The bits from column x0 to column x1, both in the image.
  [[nodiscard]] bool all_set(const std::vector<uint64_t>& bits, int y, int x0, int x1) const;
  [[nodiscard]] Opacity of_columns(int y, int x0, int x1) const;

  int width_, height_;
  TextureWrap wrap_u_, wrap_v_;
  size_t row_words_; // of 64 bits
  std::vector<uint64_t> transparent_, opaque_;
};

} // namespace kindling
