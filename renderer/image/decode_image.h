// Decoding of images from untrusted files: formats detected by magic bytes, sizes within limits.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/image/image.h"

#include <filesystem>
#include <span>
#include <string_view>

namespace kindling {

enum class ImageFormat { unknown, png, jpeg, webp, ktx2, hdr, exr };

// Detects a format by magic bytes only; names and MIME types are not used.
[[nodiscard]] ImageFormat detect_image_format(std::span<const std::byte> bytes);
[[nodiscard]] std::string_view image_format_name(ImageFormat format);

struct ImageLimits {
  int max_side_px = 32768;
  uint64_t max_pixels = 1ULL << 28; // 268 megapixels
};

// The purpose that an image is decoded for.
enum class ImageUse : uint8_t {
  any,
  normal_map // the blue of directions that is not stored is rebuilt (rebuild_blue())
};

// Decodes an image. `name` identifies it in error messages. HDR is decoded to f32, EXR to f32 or
// f16, PNG to u8 or u16, other formats to u8.
[[nodiscard]] Result<Image> decode_image(std::span<const std::byte> bytes, std::string_view name,
                                         const ImageLimits& limits = {}, ImageUse use = ImageUse::any);
[[nodiscard]] Result<Image> read_image_file(const std::filesystem::path& path, const ImageLimits& limits = {});

} // namespace kindling
