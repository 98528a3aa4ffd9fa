// Readers that decode one texel of each layout to linear values.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/half_float.h"
#include "renderer/base/simd_types.h"
#include "renderer/image/image.h"
#include "renderer/texture/srgb.h"

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>

#if defined(__SSE4_1__)
#include <immintrin.h>
#endif

namespace kindling::texture_detail {

[[nodiscard]] constexpr bool is_integer(PixelType type) { return type == PixelType::u8 || type == PixelType::u16; }

// Encodes a layout: type (2 bits), channels - 1 (2 bits), sRGB (1 bit; integers only).
inline constexpr size_t kLayoutCount = 32;
[[nodiscard]] constexpr uint8_t make_layout(PixelType type, int channels, bool srgb) {
  assert(channels >= 1 && channels <= 4);
  return static_cast<uint8_t>(static_cast<int>(type) << 3 | (channels - 1) << 1 | (srgb ? 1 : 0));
}

template <typename T>
[[nodiscard]] inline T load(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

// Reads texels of one layout: stored values, or decoded ones if kSrgb. It reads no byte past the
// texel. Raw integers must be multiplied by kScale after filtering.
template <PixelType kPixelType, int kChannels, bool kSrgb>
struct TexelReader {
  static constexpr PixelType kType = kPixelType;
  static constexpr bool kIsSrgb = kSrgb;
  static constexpr int kChannelCount = kChannels;
  static constexpr size_t kChannelBytes = bytes_per_channel(kType);
  static constexpr size_t kBytes = kChannelBytes * kChannels;
  static constexpr bool kRaw = !kSrgb && is_integer(kType); // values are 0 to 255 or 65535
  static constexpr float kScale = !kRaw ? 1.0f : kType == PixelType::u8 ? 1.0f / 255.0f : 1.0f / 65535.0f;
  static constexpr bool kHasAlpha = kChannels == 2 || kChannels == 4;

  // The same for look-ups, whose reader may be an AnyTexelReader.
  static constexpr size_t kMaxBytes = kBytes;
  [[nodiscard]] static constexpr size_t bytes() { return kBytes; }
  [[nodiscard]] static constexpr float scale() { return kScale; }
  [[nodiscard]] static constexpr int channel_count() { return kChannels; }
  [[nodiscard]] static constexpr bool has_alpha() { return kHasAlpha; }

  // Returns channel `index` of the stored channels. Alpha is never sRGB.
  [[nodiscard]] static float channel(const std::byte* texel, int index) {
    const std::byte* at = texel + static_cast<size_t>(index) * kChannelBytes;
    const bool alpha = kHasAlpha && index == kChannels - 1;
    if constexpr (kType == PixelType::u8) {
      const auto stored = load<uint8_t>(at);
      if constexpr (kSrgb) return alpha ? static_cast<float>(stored) * (1.0f / 255.0f) : decode_srgb_u8(stored);
      return static_cast<float>(stored);
    } else if constexpr (kType == PixelType::u16) {
      const auto stored = load<uint16_t>(at);
      if constexpr (kSrgb) return alpha ? static_cast<float>(stored) * (1.0f / 65535.0f) : decode_srgb_u16(stored);
      return static_cast<float>(stored);
    } else if constexpr (kType == PixelType::f16) {
      return half_to_float(load<uint16_t>(at));
    } else {
      return load<float>(at);
    }
  }

  // Returns all channels. Luminance is replicated to three channels; without alpha the fourth
  // channel is undefined.
  [[nodiscard]] static Float4 all(const std::byte* texel) {
    if constexpr (kChannels == 1) {
      const float l = channel(texel, 0);
      return Float4{l, l, l, l};
    } else if constexpr (kChannels == 2) {
      const float l = channel(texel, 0);
      return Float4{l, l, l, channel(texel, 1)};
    } else {
      return three_or_four(texel);
    }
  }

 private:
  [[nodiscard]] static Float4 three_or_four(const std::byte* texel) {
#if defined(__SSE4_1__)
    if constexpr (kRaw && kType == PixelType::u8) {
      const uint32_t bits = kChannels == 4
                                ? load<uint32_t>(texel)
                                : load<uint16_t>(texel) | static_cast<uint32_t>(load<uint8_t>(texel + 2)) << 16;
      return (Float4)_mm_cvtepi32_ps(_mm_cvtepu8_epi32(_mm_cvtsi32_si128(static_cast<int>(bits))));
    }
    if constexpr (kRaw && kType == PixelType::u16)
      return (Float4)_mm_cvtepi32_ps(_mm_cvtepu16_epi32(load_words(texel)));
#endif
#if defined(__F16C__)
    if constexpr (kType == PixelType::f16) return (Float4)_mm_cvtph_ps(load_words(texel));
#endif
    if constexpr (kType == PixelType::f32 && kChannels == 4) return load<Float4>(texel);
    return Float4{channel(texel, 0), channel(texel, 1), channel(texel, 2), kChannels == 4 ? channel(texel, 3) : 1.0f};
  }

#if defined(__SSE4_1__)
  [[nodiscard]] static __m128i load_words(const std::byte* texel) {
    const uint64_t bits = kChannels == 4
                              ? load<uint64_t>(texel)
                              : load<uint32_t>(texel) | static_cast<uint64_t>(load<uint16_t>(texel + 4)) << 32;
    return _mm_cvtsi64_si128(static_cast<long long>(bits));
  }
#endif
};

template <size_t kLayout>
using ReaderOfLayout = TexelReader<static_cast<PixelType>(kLayout >> 3), static_cast<int>(kLayout >> 1 & 3) + 1,
                                   (kLayout & 1) != 0 && is_integer(static_cast<PixelType>(kLayout >> 3))>;

} // namespace kindling::texture_detail
