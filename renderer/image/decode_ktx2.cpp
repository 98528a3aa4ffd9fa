// KTX2 decoder: level 0 of Basis Universal payloads, to RGB or RGBA, and of the formats of Vulkan.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decoders.h"
#include "renderer/image/etc1s_slices.h"
#include "renderer/image/ktx2_container.h"
#include "renderer/image/ktx2_texels.h"
#include "renderer/image/rebuild_blue.h"
#include "renderer/image/uastc_block.h"

#include <fmt/format.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

namespace kindling::image_detail {

namespace {

// Returns the blocks of the level, in `buffer` if they were compressed. A level that is too small
// for its decompressed size is refused before memory is allocated: deflate compresses at most 1032
// : 1, Zstandard to 4 bytes for each 128 KiB.
Result<Bytes> inflate_level(const Ktx2Texture& texture, std::vector<std::byte>& buffer) {
  if (texture.supercompression == Ktx2Supercompression::none) return texture.level;
  const bool zlib = texture.supercompression == Ktx2Supercompression::zlib;
  if (texture.inflated_bytes / (zlib ? 1032 : 32768) > texture.level.size()) {
    return detail_error(
        fmt::format("{} bytes cannot hold {} x {} pixels", texture.level.size(), texture.width, texture.height));
  }
  buffer.resize(texture.inflated_bytes);
  size_t written = 0;
  if (zlib) {
    uLongf size = buffer.size();
    const int status = uncompress(reinterpret_cast<Bytef*>(buffer.data()), &size,
                                  reinterpret_cast<const Bytef*>(texture.level.data()), texture.level.size());
    if (status != Z_OK) return detail_error("its zlib data are corrupt");
    written = size;
  } else {
    written = ZSTD_decompress(buffer.data(), buffer.size(), texture.level.data(), texture.level.size());
    if (ZSTD_isError(written) != 0) {
      return detail_error(fmt::format("its Zstandard data are corrupt ({})", ZSTD_getErrorName(written)));
    }
  }
  if (written != buffer.size()) {
    return detail_error(fmt::format("its level 0 has {} bytes instead of {}", written, buffer.size()));
  }
  return Bytes(buffer);
}

// Visits the pixels of a block that are inside of the image.
class BlockWriter {
 public:
  BlockWriter(Image& image, uint32_t block_x, uint32_t block_y)
      : image_(image), x_(4 * static_cast<int>(block_x)), y_(4 * static_cast<int>(block_y)) {}

  // Calls write(pixel, index), where `pixel` points to the channels and `index` counts the block's
  // pixels.
  template <typename Write>
  void each(const Write& write) const {
    const int columns = std::min(4, image_.width - x_), rows = std::min(4, image_.height - y_);
    auto* pixels = reinterpret_cast<uint8_t*>(image_.pixels.data());
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < columns; ++x) {
        const size_t at = static_cast<size_t>(y_ + y) * static_cast<size_t>(image_.width) + static_cast<size_t>(x_ + x);
        write(pixels + at * static_cast<size_t>(image_.channels), static_cast<size_t>(4 * y + x));
      }
    }
  }

 private:
  Image& image_;
  int x_, y_;
};

Image allocate_pixels(const Ktx2Texture& texture) {
  return make_image(static_cast<int>(texture.width), static_cast<int>(texture.height),
                    texture.channels == Ktx2Channels::rgba ? 4 : 3, PixelType::u8);
}

Result<Image> decode_uastc(const Ktx2Texture& texture) {
  std::vector<std::byte> buffer;
  const Result<Bytes> blocks = inflate_level(texture, buffer);
  if (!blocks) return blocks.error();
  Image image = allocate_pixels(texture);
  size_t at = 0;
  for (uint32_t y = 0; y < texture.blocks_y(); ++y) {
    for (uint32_t x = 0; x < texture.blocks_x(); ++x, at += 16) {
      BlockTexels texels;
      if (!decode_uastc_block(blocks.value().subspan(at).first<16>(), texels)) {
        return detail_error(fmt::format("its UASTC block ({}, {}) is invalid", x, y));
      }
      if (texture.channels == Ktx2Channels::green_from_alpha) {
        for (auto& texel : texels) texel = {texel[0], texel[3], 0, 255};
      }
      BlockWriter(image, x, y).each([&](uint8_t* pixel, size_t i) {
        std::memcpy(pixel, texels[i].data(), static_cast<size_t>(image.channels));
      });
    }
  }
  return image;
}

Result<Image> decode_etc1s(const Ktx2Texture& texture) {
  const Result<Etc1sData> read = read_etc1s_data(texture.supercompression_globals, texture.levels);
  if (!read) return read.error();
  const Etc1sData& data = read.value();
  const bool second_slice = texture.channels != Ktx2Channels::rgb;
  const auto slice = [&](const Etc1sSliceRange& range) -> Result<Bytes> {
    if (range.length == 0 || range.offset > texture.level.size() ||
        range.length > texture.level.size() - range.offset) {
      return detail_error(fmt::format("its slice ({} bytes at {}) is not within level 0 of {} bytes", range.length,
                                      range.offset, texture.level.size()));
    }
    return texture.level.subspan(range.offset, range.length);
  };
  const Result<Bytes> color = slice(data.color_slice);
  if (!color) return color.error();
  const Result<Bytes> alpha = second_slice ? slice(data.alpha_slice) : Result<Bytes>(Bytes{});
  if (!alpha) return alpha.error();

  Image image = allocate_pixels(texture);
  const auto write_color = [&](uint32_t x, uint32_t y, const Etc1sEndpoint& endpoint, const Etc1sSelector& selector) {
    const auto colors = etc1s_colors(endpoint);
    BlockWriter(image, x, y).each([&](uint8_t* pixel, size_t i) {
      std::memcpy(pixel, colors[selector.at(i)].data(), 3);
      if (image.channels == 4) pixel[3] = 255;
    });
  };
  // Alpha, or green of red-green textures, is the green channel of the second slice.
  const auto write_alpha = [&](uint32_t x, uint32_t y, const Etc1sEndpoint& endpoint, const Etc1sSelector& selector) {
    const auto colors = etc1s_colors(endpoint);
    const bool is_green = texture.channels == Ktx2Channels::green_from_alpha;
    BlockWriter(image, x, y).each([&](uint8_t* pixel, size_t i) {
      pixel[is_green ? 1 : 3] = colors[selector.at(i)][1];
      if (is_green) pixel[2] = 0;
    });
  };
  if (!decode_etc1s_slice(color.value(), data, texture.blocks_x(), texture.blocks_y(), write_color)) {
    return detail_error("its ETC1S slice is corrupt");
  }
  if (second_slice && !decode_etc1s_slice(alpha.value(), data, texture.blocks_x(), texture.blocks_y(), write_alpha)) {
    return detail_error("its second ETC1S slice is corrupt");
  }
  return image;
}

Result<Image> decode_payload(const Ktx2Texture& texture) {
  if (texture.payload == Ktx2Payload::vulkan) {
    std::vector<std::byte> buffer;
    const Result<Bytes> level = inflate_level(texture, buffer);
    if (!level) return level.error();
    return decode_ktx2_texels(texture, level.value());
  }
  return texture.payload == Ktx2Payload::uastc ? decode_uastc(texture) : decode_etc1s(texture);
}

} // namespace

Result<Image> decode_ktx2(Bytes bytes, const ImageLimits& limits, ImageUse use) {
  const Result<Ktx2Texture> texture = parse_ktx2(bytes);
  if (!texture) return texture.error();
  if (const auto error = check_size(texture.value().width, texture.value().height, limits)) return detail_error(*error);
  Result<Image> image = decode_payload(texture.value());
  const std::array<char, 4>& swizzle = texture.value().swizzle;
  const auto is_constant = [](char channel) { return channel == '0' || channel == '1'; };
  const bool constant_blue = is_constant(swizzle[2]) && !is_constant(swizzle[0]) && !is_constant(swizzle[1]);
  if (image && use == ImageUse::normal_map) rebuild_blue(image.value(), constant_blue);
  return image;
}

} // namespace kindling::image_detail
