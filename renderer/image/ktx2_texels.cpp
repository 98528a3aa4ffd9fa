// Images from blocks of texels: channels are selected, and texels beyond the edges dropped.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/ktx2_texels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace kindling::image_detail {

namespace {

// Where the channels of the image come from: 0 to 3 is a stored channel, kZero and kOne are
// constants.
struct ChannelMap {
  static constexpr size_t kZero = 4, kOne = 5;
  std::array<size_t, 4> from{};
  int count = 0;

  [[nodiscard]] bool is_identity(size_t stored) const {
    if (static_cast<size_t>(count) != stored) return false;
    for (size_t c = 0; c < stored; ++c) {
      if (from[c] != c) return false;
    }
    return true;
  }
};

ChannelMap map_channels(const Ktx2Format& format, const std::array<char, 4>& swizzle) {
  std::array<size_t, 4> from{};
  for (size_t c = 0; c < 4; ++c) {
    const size_t stored = std::string_view("rgba01").find(swizzle[c]);
    from[c] = stored > 3 || stored < format.channels ? stored : stored == 3 ? ChannelMap::kOne : ChannelMap::kZero;
  }
  const bool opaque = from[3] == ChannelMap::kOne;
  if (from[0] == from[1] && from[1] == from[2]) return {{from[0], from[3]}, opaque ? 1 : 2};
  return {from, opaque ? 3 : 4};
}

uint32_t one_of(PixelType type) {
  switch (type) {
  case PixelType::u8: return 255;
  case PixelType::u16: return 65535;
  case PixelType::f16: return 0x3c00;
  case PixelType::f32: break;
  }
  return 0x3f800000;
}

// Stores the selected channels of a texel.
template <typename T>
void store_texel(const Texel& texel, const ChannelMap& map, uint32_t one, std::byte* to) {
  const std::array<uint32_t, 6> values = {texel[0], texel[1], texel[2], texel[3], 0, one};
  for (size_t c = 0; c < static_cast<size_t>(map.count); ++c) {
    const T value = static_cast<T>(values[map.from[c]]);
    std::memcpy(to + c * sizeof value, &value, sizeof value);
  }
}

} // namespace

Result<Image> decode_ktx2_texels(const Ktx2Texture& texture, Bytes level) {
  const Ktx2Format& format = *texture.format;
  const ChannelMap map = map_channels(format, texture.swizzle);
  Image image = make_image(static_cast<int>(texture.width), static_cast<int>(texture.height), map.count, format.type);
  if (format.encoding == Ktx2Encoding::plain && map.is_identity(format.channels)) {
    std::copy(level.begin(), level.end(), image.pixels.begin());
    return image;
  }
  const size_t channel_bytes = bytes_per_channel(format.type);
  const auto store = channel_bytes == 1   ? store_texel<uint8_t>
                     : channel_bytes == 2 ? store_texel<uint16_t>
                                          : store_texel<uint32_t>;
  const size_t texel_bytes = channel_bytes * static_cast<size_t>(map.count);
  const uint32_t one = one_of(format.type);
  TexelBlock texels{};
  for (uint32_t by = 0, at = 0; by < texture.blocks_y(); ++by) {
    for (uint32_t bx = 0; bx < texture.blocks_x(); ++bx, ++at) {
      const Bytes block = level.subspan(size_t{at} * format.bytes, format.bytes);
      if (!decode_ktx2_block(format, block, texels)) {
        return detail_error(fmt::format("its {} block ({}, {}) is invalid", format.name, bx, by));
      }
      const uint32_t x0 = bx * format.block_width, y0 = by * format.block_height;
      const uint32_t columns = std::min<uint32_t>(format.block_width, texture.width - x0);
      const uint32_t rows = std::min<uint32_t>(format.block_height, texture.height - y0);
      for (uint32_t y = 0; y < rows; ++y) {
        std::byte* to = image.pixels.data() + (size_t{y0 + y} * texture.width + x0) * texel_bytes;
        for (uint32_t x = 0; x < columns; ++x) {
          store(texels[size_t{y} * format.block_width + x], map, one, to + x * texel_bytes);
        }
      }
    }
  }
  return image;
}

} // namespace kindling::image_detail
