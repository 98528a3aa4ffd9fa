// Reads opaque PNG files of 8 bits.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/output/video_frame.h"

#include "renderer/image/decode_image.h"

#include <cstddef>
#include <utility>

namespace kindling::app {

std::optional<VideoFrame> read_video_frame(const std::filesystem::path& image) {
  if (image.extension() != ".png") return std::nullopt;
  const Result<Image> read = read_image_file(image);
  if (!read.ok()) return std::nullopt;
  const Image& pixels = read.value();
  if (pixels.type != PixelType::u8 || (pixels.channels != 3 && pixels.channels != 4)) return std::nullopt;
  const auto channels = static_cast<size_t>(pixels.channels);
  const size_t count = static_cast<size_t>(pixels.width) * static_cast<size_t>(pixels.height);
  VideoFrame frame{std::vector<uint8_t>(3 * count), V2i(pixels.width, pixels.height)};
  for (size_t i = 0; i < count; ++i) {
    const std::byte* const pixel = &pixels.pixels[i * channels];
    // Videos composite over black before the view, PNG files have straight alpha behind it.
    if (channels == 4 && pixel[3] != std::byte{255}) return std::nullopt;
    for (size_t c = 0; c < 3; ++c) frame.rgb[3 * i + c] = std::to_integer<uint8_t>(pixel[c]);
  }
  return frame;
}

} // namespace kindling::app
