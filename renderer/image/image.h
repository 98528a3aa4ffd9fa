// Decoded image in memory, at the bit depth of its file.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace kindling {

enum class PixelType : uint8_t { u8, u16, f16, f32 };

[[nodiscard]] constexpr size_t bytes_per_channel(PixelType type) {
  return type == PixelType::u8 ? 1 : type == PixelType::f32 ? 4 : 2;
}

// An image with interleaved channels, rows from the top and no padding. 1 to 4 channels are L, LA,
// RGB or RGBA with straight alpha.
struct Image {
  int width = 0;
  int height = 0;
  int channels = 0;
  PixelType type = PixelType::u8;
  std::vector<std::byte> pixels;

  [[nodiscard]] size_t byte_count() const {
    return static_cast<size_t>(width) * static_cast<size_t>(height) * static_cast<size_t>(channels) *
           bytes_per_channel(type);
  }
};

} // namespace kindling
