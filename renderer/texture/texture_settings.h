// How an image is read as a texture: the words of glTF's samplers.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace kindling {

enum class TextureWrap : uint8_t { repeat, mirrored_repeat, clamp_to_edge };
enum class TextureFilter : uint8_t { nearest, linear };
// How stored values become linear ones: color textures of glTF are sRGB (RGB only; alpha is always linear), others
// linear. Images with float texels are linear already and read as such with either.
enum class TextureEncoding : uint8_t { linear, srgb };

struct TextureSettings {
  TextureWrap wrap_u = TextureWrap::repeat;
  TextureWrap wrap_v = TextureWrap::repeat;
  TextureFilter filter = TextureFilter::linear;
  TextureEncoding encoding = TextureEncoding::linear;
};

} // namespace kindling
