// Decoders of all image formats; each checks sizes first and decodes directly into Image::pixels.
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

// Returns an error that contains the detail only ("truncated data"); decode_image() prepends the
// name and the format.
[[nodiscard]] inline Error detail_error(std::string detail) { return {ErrorKind::input_output, std::move(detail)}; }

[[nodiscard]] Result<Image> decode_png(Bytes bytes, const ImageLimits& limits);
[[nodiscard]] Result<Image> decode_jpeg(Bytes bytes, const ImageLimits& limits);
[[nodiscard]] Result<Image> decode_webp(Bytes bytes, const ImageLimits& limits);
[[nodiscard]] Result<Image> decode_ktx2(Bytes bytes, const ImageLimits& limits, ImageUse use);
[[nodiscard]] Result<Image> decode_hdr(Bytes bytes, const ImageLimits& limits);
[[nodiscard]] Result<Image> decode_exr(Bytes bytes, const ImageLimits& limits);

// Checks OpenEXR headers before the library allocates memory: windows must be within the limits and
// chunk tables must fit into the file. Returns nothing on success, else the detail of the error.
[[nodiscard]] std::optional<std::string> check_exr_headers(Bytes bytes, const ImageLimits& limits);

// Checks a size against the limits. Returns nothing on success, else the detail of the error.
[[nodiscard]] std::optional<std::string> check_size(int64_t width, int64_t height, const ImageLimits& limits);

// Returns an image with allocated pixels, all zero.
[[nodiscard]] Image make_image(int width, int height, int channels, PixelType type);

// Returns the first line of a library's message, without trailing spaces.
[[nodiscard]] std::string first_line(std::string text);

} // namespace kindling::image_detail
