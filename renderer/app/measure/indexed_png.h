// Small PNG images in memory, one byte for each pixel, for pages that are complete in themselves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace kindling::app {

using Palette = std::array<std::array<uint8_t, 3>, 256>; // sRGB

// The bytes of a PNG file (PNG specification 3rd ed.; color type 3, 8 bits). Not compressed: the deflate blocks are stored.
// pixels.size() == width * height, row by row from the top.
[[nodiscard]] std::string encode_indexed_png(std::span<const uint8_t> pixels, int width, int height,
                                             const Palette& palette);

// RFC 4648, with padding.
[[nodiscard]] std::string encode_base64(std::string_view bytes);

} // namespace kindling::app
