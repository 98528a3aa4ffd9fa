// Prepares textures for look-ups: their layout, levels and settings.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/texture.h"

#include "renderer/texture/layouts.h"
#include "renderer/texture/texel_fetch.h"

#include <cassert>
#include <utility>

namespace kindling {
namespace {

using texture_detail::is_integer;
using texture_detail::make_layout;
using texture_detail::with_layout;

template <typename Reader>
bool is_opaque(const TextureView& t) {
  if constexpr (Reader::kHasAlpha) {
    const TextureView::Level& level = t.levels[0];
    const size_t pixel_count = static_cast<size_t>(level.width) * static_cast<size_t>(level.height);
    for (size_t i = 0; i < pixel_count; ++i) {
      if (Reader::channel(level.pixels + i * Reader::kBytes, Reader::kChannelCount - 1) * Reader::kScale != 1.0f)
        return false;
    }
  }
  return true;
}

} // namespace

Texture::Texture(const Image& format, const TextureSettings& settings) {
  assert(format.width > 0 && format.height > 0 && format.channels >= 1 && format.channels <= 4);
  texel_count = static_cast<float>(format.width) * static_cast<float>(format.height);
  layout =
      make_layout(format.type, format.channels, settings.encoding == TextureEncoding::srgb && is_integer(format.type));
  pixel_bytes = static_cast<uint8_t>(bytes_per_channel(format.type) * static_cast<size_t>(format.channels));
  wrap_u = settings.wrap_u;
  wrap_v = settings.wrap_v;
  filter = settings.filter;
  repeats = wrap_u == TextureWrap::repeat && wrap_v == TextureWrap::repeat;
  levels[0] = {nullptr, format.width, format.height};
}

Texture::Texture(std::shared_ptr<const Image> image, const TextureSettings& settings,
                 std::shared_ptr<const MipLevels> mips)
    : Texture(*image, settings) {
  assert(image->pixels.size() >= image->byte_count());
  image_ = std::move(image);
  mip_levels_ = std::move(mips);
  levels[0].pixels = image_->pixels.data();
  if (mip_levels_) {
    for (const MipLevels::Level& level : mip_levels_->levels)
      levels[static_cast<size_t>(level_count++)] = {mip_levels_->pixels.data() + level.offset, level.width,
                                                    level.height};
    has_alpha = !mip_levels_->opaque;
  } else {
    has_alpha = !with_layout(layout, [this]<typename Reader>() { return is_opaque<Reader>(*this); });
  }
}

Texture::Texture(std::shared_ptr<const TiledImage> tiled, const Image& format, const TextureSettings& settings,
                 const MipLevels& sizes)
    : Texture(format, settings) {
  tiles_ = std::move(tiled);
  pages = tiles_.get();
  for (const MipLevels::Level& level : sizes.levels)
    levels[static_cast<size_t>(level_count++)] = {nullptr, level.width, level.height};
  has_alpha = !sizes.opaque;
}

void TextureView::fetch(int level, const std::array<int, 2>& x, const std::array<int, 2>& y, std::byte* texels) const {
  if (tiles != nullptr) {
    tiles->fetch(level, x, y, pixel_bytes, texels);
    return;
  }
  assert(pages != nullptr);
  pages->fetch(level, x, y, texels);
}

} // namespace kindling
