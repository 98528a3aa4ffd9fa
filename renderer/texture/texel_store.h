// Writers that encode linear values as one texel of each layout, the inverse of texel_fetch.h.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/texture/srgb.h"
#include "renderer/texture/texel_fetch.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

namespace kindling::texture_detail {

template <typename T>
inline void store(T value, std::byte* to) {
  std::memcpy(to, &value, sizeof value);
}

// Clamps to [0, 1]; 0 for NaN.
[[nodiscard]] inline float in_unit_interval(float value) { return std::min(std::max(0.0f, value), 1.0f); }

// Stores a linear value, in [0, 1] for integer types, rounded to nearest.
template <typename Reader, bool kAlpha>
inline void store_channel(float value, std::byte* to) {
  if constexpr (Reader::kType == PixelType::u8) {
    if constexpr (Reader::kIsSrgb && !kAlpha)
      store(encode_srgb_u8(value), to);
    else
      store(static_cast<uint8_t>(in_unit_interval(value) * 255.0f + 0.5f), to);
  } else if constexpr (Reader::kType == PixelType::u16) {
    if constexpr (Reader::kIsSrgb && !kAlpha)
      store(encode_srgb_u16(value), to);
    else
      store(static_cast<uint16_t>(in_unit_interval(value) * 65535.0f + 0.5f), to);
  } else if constexpr (Reader::kType == PixelType::f16) {
    store(Imath::half(value), to);
  } else {
    store(value, to);
  }
}

// Stores a texel in the format of Reader::all() times Reader::kScale.
template <typename Reader>
inline void store_texel(const Float4& texel, std::byte* to) {
  constexpr int kColors = Reader::kHasAlpha ? Reader::kChannelCount - 1 : Reader::kChannelCount;
  for (int c = 0; c < kColors; ++c)
    store_channel<Reader, false>(texel[c], to + static_cast<size_t>(c) * Reader::kChannelBytes);
  if constexpr (Reader::kHasAlpha) store_channel<Reader, true>(texel[3], to + kColors * Reader::kChannelBytes);
}

} // namespace kindling::texture_detail
