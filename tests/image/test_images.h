// Small encoded images in memory, in every supported format, for tests of decoders.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/image/decode_image.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kindling::test {

using FileBytes = std::vector<std::byte>;

[[nodiscard]] FileBytes bytes_of(std::string_view text);

// Decodes a file; if that fails, the test fails and the image is empty.
[[nodiscard]] Image decoded(const FileBytes& file);
// Returns the error of a file named "some name" that cannot be decoded; if it can be, the test
// fails.
[[nodiscard]] std::string decode_error(const FileBytes& file, const ImageLimits& limits = {});

// Returns an image of random values with a fixed seed; floats are in [0, 4).
[[nodiscard]] Image make_noise_image(int width, int height, int channels, PixelType type, uint32_t seed = 1);

// Encodes an image with OpenImageIO ("png", "hdr", "openexr"). `names` are the channel names of
// EXR.
[[nodiscard]] FileBytes encode_with_oiio(const Image& image, const std::string& format,
                                         const std::vector<std::string>& names = {});
// Encodes an EXR whose data window is a part of a display window of the given size, at the given
// corner.
[[nodiscard]] FileBytes encode_exr_window(const Image& image, int x, int y, int full_width, int full_height);
[[nodiscard]] FileBytes encode_exr_tiled(const Image& image, int tile_side);
// Encodes an EXR of two parts: one with the channel "mask", then the image.
[[nodiscard]] FileBytes encode_exr_mask_and_image(const Image& mask, const Image& image);
[[nodiscard]] FileBytes encode_webp_lossless(const Image& image);
// Encodes a JPEG; color_components is 1, 3 or 4 (CMYK, with Adobe's marker and inverted ink).
[[nodiscard]] FileBytes encode_jpeg(std::span<const uint8_t> samples, int width, int height, int components,
                                    bool progressive);

// Assembles a PNG from chunks, without compression. color_type, bit_depth and rows are as in the
// specification; the filter byte 0 is added to each row. `extra` is inserted between IHDR and IDAT.
struct PngChunk {
  std::string type;
  std::vector<uint8_t> data;
};
[[nodiscard]] FileBytes make_png(uint32_t width, uint32_t height, uint8_t bit_depth, uint8_t color_type,
                                 const std::vector<std::vector<uint8_t>>& rows,
                                 const std::vector<PngChunk>& extra = {});

// Returns the chunks of a PNG file.
[[nodiscard]] std::vector<PngChunk> read_png_chunks(const FileBytes& file);

[[nodiscard]] FileBytes read_file(const std::string& path);

} // namespace kindling::test
