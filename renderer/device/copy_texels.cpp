// Copies texels from memory, or from pages two by two.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/copy_texels.h"

#include <algorithm>
#include <array>

namespace kindling {

void copy_texels(const TextureView& texture, const TexelRect& rect, std::byte* to, size_t row_bytes) {
  const TextureView::Level& level = texture.levels[static_cast<size_t>(rect.level)];
  const size_t texel_bytes = texture.pixel_bytes;
  if (level.pixels != nullptr) {
    for (int y = 0; y < rect.height; ++y) {
      const size_t first =
          static_cast<size_t>(rect.y + y) * static_cast<size_t>(level.width) + static_cast<size_t>(rect.x);
      std::copy_n(level.pixels + first * texel_bytes, static_cast<size_t>(rect.width) * texel_bytes,
                  to + static_cast<size_t>(y) * row_bytes);
    }
    return;
  }
  std::array<std::byte, 4 * 16> square; // of four texels
  for (int y = 0; y < rect.height; y += 2)
    for (int x = 0; x < rect.width; x += 2) {
      const std::array<int, 2> columns{x, std::min(x + 1, rect.width - 1)};
      const std::array<int, 2> rows{y, std::min(y + 1, rect.height - 1)};
      texture.fetch(rect.level, {rect.x + columns[0], rect.x + columns[1]}, {rect.y + rows[0], rect.y + rows[1]},
                    square.data());
      for (size_t i = 0; i < 4; ++i)
        std::copy_n(square.data() + i * texel_bytes, texel_bytes,
                    to + static_cast<size_t>(rows[i / 2]) * row_bytes +
                        static_cast<size_t>(columns[i % 2]) * texel_bytes);
    }
}

} // namespace kindling
