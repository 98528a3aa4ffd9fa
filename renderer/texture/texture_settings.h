// Settings of textures, with the terms of glTF samplers: wrap, filter, encoding.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace kindling {

enum class TextureWrap : uint8_t { repeat, mirrored_repeat, clamp_to_edge };
enum class TextureFilter : uint8_t { nearest, linear };
// The encoding of stored values. In glTF, color textures are sRGB (RGB only; alpha is always
// linear) and others linear. Images of floats are always linear.
enum class TextureEncoding : uint8_t { linear, srgb };

struct TextureSettings {
  TextureWrap wrap_u = TextureWrap::repeat;
  TextureWrap wrap_v = TextureWrap::repeat;
  TextureFilter filter = TextureFilter::linear;
  TextureEncoding encoding = TextureEncoding::linear;
};

} // namespace kindling
