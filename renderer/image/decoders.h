// The decoders behind decode_image(), one per format: each checks sizes first and fills Image::pixels in place.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/image/decode_image.h"
#include "renderer/image/image.h"

#include <optional>
#include <span>
#include <string>
#include <utility>

namespace kindling::image_detail {

using Bytes = std::span<const std::byte>;

// Errors carry the detail alone ("truncated data"); decode_image() puts the name and the format before it.
[[nodiscard]] inline Error detail_error(std::string detail) { return {ErrorKind::input_output, std::move(detail)}; }

[[nodiscard]] Result<Image> decode_png(Bytes bytes, const ImageLimits& limits);
[[nodiscard]] Result<Image> decode_jpeg(Bytes bytes, const ImageLimits& limits);
[[nodiscard]] Result<Image> decode_webp(Bytes bytes, const ImageLimits& limits);
[[nodiscard]] Result<Image> decode_ktx2(Bytes bytes, const ImageLimits& limits);
[[nodiscard]] Result<Image> decode_hdr(Bytes bytes, const ImageLimits& limits);
[[nodiscard]] Result<Image> decode_exr(Bytes bytes, const ImageLimits& limits);

// What an OpenEXR header promises, checked before the library allocates for it: windows within the limits, and chunk
// tables that fit in the file. Empty when all is well, else the detail.
[[nodiscard]] std::optional<std::string> check_exr_headers(Bytes bytes, const ImageLimits& limits);

// Empty when within the limits, else the detail of the error.
[[nodiscard]] std::optional<std::string> check_size(int64_t width, int64_t height, const ImageLimits& limits);

// An image of that shape with its pixels allocated (zero).
[[nodiscard]] Image make_image(int width, int height, int channels, PixelType type);

// The one-line form of a library's message: cut at the first line break, trailing space removed.
[[nodiscard]] std::string first_line(std::string text);

} // namespace kindling::image_detail
