// Encodes small PNG images with a palette, and base64, for self-contained pages.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace kindling::app {

using Palette = std::array<std::array<uint8_t, 3>, 256>; // sRGB

// Returns the bytes of a PNG file (PNG specification 3rd ed.; color type 3, 8 bits) with stored,
// uncompressed deflate blocks. pixels.size() == width * height, row by row from the top.
[[nodiscard]] std::string encode_indexed_png(std::span<const uint8_t> pixels, int width, int height,
                                             const Palette& palette);

// Encodes by RFC 4648, with padding.
[[nodiscard]] std::string encode_base64(std::string_view bytes);

} // namespace kindling::app
