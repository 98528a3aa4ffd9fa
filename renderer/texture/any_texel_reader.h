// Reader of texels whose layout is known at run time, for GPUs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/half_float.h"
#include "renderer/base/simd_types.h"
#include "renderer/image/image.h"
#include "renderer/texture/srgb.h"
#include "renderer/texture/texel_fetch.h"

#include <cstddef>
#include <cstdint>

namespace kindling::texture_detail {

// Has the values of the TexelReader of its layout, bit for bit.
class AnyTexelReader {
 public:
  // `layout` is from make_layout().
  explicit AnyTexelReader(uint8_t layout)
      : type_(static_cast<PixelType>(layout >> 3)), channel_count_((layout >> 1 & 3) + 1),
        srgb_((layout & 1) != 0 && is_integer(type_)) {}

  static constexpr size_t kMaxBytes = 4 * sizeof(float);
  [[nodiscard]] size_t bytes() const { return bytes_per_channel(type_) * static_cast<size_t>(channel_count_); }
  [[nodiscard]] float scale() const {
    if (srgb_ || !is_integer(type_)) return 1.0f;
    return type_ == PixelType::u8 ? 1.0f / 255.0f : 1.0f / 65535.0f;
  }
  [[nodiscard]] int channel_count() const { return channel_count_; }
  [[nodiscard]] bool has_alpha() const { return channel_count_ == 2 || channel_count_ == 4; }

  [[nodiscard]] float channel(const std::byte* texel, int index) const {
    const std::byte* at = texel + static_cast<size_t>(index) * bytes_per_channel(type_);
    const bool alpha = has_alpha() && index == channel_count_ - 1;
    switch (type_) {
    case PixelType::u8: {
      const auto stored = load<uint8_t>(at);
      if (srgb_) return alpha ? static_cast<float>(stored) * (1.0f / 255.0f) : decode_srgb_u8(stored);
      return static_cast<float>(stored);
    }
    case PixelType::u16: {
      const auto stored = load<uint16_t>(at);
      if (srgb_) return alpha ? static_cast<float>(stored) * (1.0f / 65535.0f) : decode_srgb_u16(stored);
      return static_cast<float>(stored);
    }
    case PixelType::f16: return half_to_float(load<uint16_t>(at));
    case PixelType::f32: break;
    }
    return load<float>(at);
  }

  [[nodiscard]] Float4 all(const std::byte* texel) const {
    const float first = channel(texel, 0);
    if (channel_count_ < 3) return Float4{first, first, first, channel_count_ == 2 ? channel(texel, 1) : first};
    return Float4{first, channel(texel, 1), channel(texel, 2), channel_count_ == 4 ? channel(texel, 3) : 1.0f};
  }

 private:
  PixelType type_;
  int channel_count_;
  bool srgb_;
};

} // namespace kindling::texture_detail
