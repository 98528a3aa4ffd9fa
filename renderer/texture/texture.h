// A 2-D texture: texels at their file's bit depth, wrapped, filtered and decoded to linear values on look-up.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/image/image.h"

#include <cstdint>
#include <memory>

namespace kindling {

enum class TextureWrap : uint8_t { repeat, mirrored_repeat, clamp_to_edge };
enum class TextureFilter : uint8_t { nearest, linear };
// How stored values become linear ones: colour textures of glTF are sRGB (RGB only; alpha is always linear), others
// linear. Pictures with float texels are linear already and read as such with either.
enum class TextureEncoding : uint8_t { linear, srgb };

struct TextureSettings {
  TextureWrap wrap_u = TextureWrap::repeat;
  TextureWrap wrap_v = TextureWrap::repeat;
  TextureFilter filter = TextureFilter::linear;
  TextureEncoding encoding = TextureEncoding::linear;
};

// Immutable, thread-safe, cheap to copy: pixels are shared (one picture used as colour and as data is held once).
class Texture {
 public:
  // The image is complete: at least one pixel, 1 to 4 channels, byte_count() bytes.
  Texture(std::shared_ptr<const Image> image, const TextureSettings& settings);

  // uv as glTF has it: (0, 0) is the corner of the top-left texel. Non-finite uv reads as (0, 0).
  // Missing channels: L is replicated to RGB; alpha is 1. Integers read as [0, 1]. Texels are decoded before they are
  // filtered.
  [[nodiscard]] V4f sample(const V2f& uv) const;
  [[nodiscard]] Rgb sample_rgb(const V2f& uv) const;
  // One channel of 0..3, as sample() would give it.
  [[nodiscard]] float sample_channel(const V2f& uv, int channel) const;

  // Asks for the memory that a look-up at uv will read.
  void prefetch(const V2f& uv) const;

  // The mean of sample_rgb() over a triangle in uv space, by a fixed point set about as dense as its texels (16 to
  // 65536 points): for the power of an emissive triangle. The same for the same arguments, always.
  [[nodiscard]] Rgb average_rgb(const V2f& uv0, const V2f& uv1, const V2f& uv2) const;

  [[nodiscard]] V2i size_px() const { return {width_, height_}; }
  // False: alpha is exactly 1 everywhere, because there is no alpha channel or all of it is opaque.
  [[nodiscard]] bool has_alpha() const { return has_alpha_; }

 private:
  struct Lookup;

  std::shared_ptr<const Image> image_;
  const std::byte* pixels_;
  int width_;
  int height_;
  uint8_t layout_;      // make_layout() of texel_fetch.h: which code reads a texel
  uint8_t pixel_bytes_; // of one texel
  TextureWrap wrap_u_;
  TextureWrap wrap_v_;
  TextureFilter filter_;
  bool repeats_; // both axes: the common case, on a path of its own
  bool has_alpha_;
};

} // namespace kindling
