// Messages to the image viewer tev, as bytes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/film.h"

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kindling::app {

// The protocol of tev 1.17 and later (https://github.com/Tom94/tev, include/tev/Ipc.h): a message
// is its length in bytes, which counts itself (uint32), a type (a byte), and fields: flags of a
// byte, int32, int64, float, and strings that end with a 0, all little-endian. Images have the
// channels R, G, B and A, linear and premultiplied.

// Makes a black image with this name, in place of an older one, and shows it.
[[nodiscard]] std::vector<std::byte> tev_create_image(std::string_view name, const V2i& size_px);

// Sets a rectangle of an image: `rgba` has four values for each of its pixels, rows from the top.
[[nodiscard]] std::vector<std::byte> tev_update_image(std::string_view name, const PixelRect& rect,
                                                      std::span<const float> rgba);

} // namespace kindling::app
