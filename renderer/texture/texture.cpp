// Texture look-ups: wrapping, fetching, decoding and filtering of texels.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/texture.h"

#include "renderer/base/prefetch.h"
#include "renderer/texture/layouts.h"
#include "renderer/texture/texel_fetch.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

namespace kindling {

namespace {

using texture_detail::for_each_layout;
using texture_detail::is_integer;
using texture_detail::make_layout;

// Pixel indices of the four texels around a point, and the position of the point between them.
struct Footprint {
  size_t top_left, top_right, bottom_left, bottom_right;
  float tx, ty;
};

bool is_finite(const V2f& uv) { return (uv.x - uv.x) + (uv.y - uv.y) == 0.0f; }

// Maps to [0, 1]. Rounding can give 1, which callers treat as the end of the axis.
float wrap_coordinate(float u, TextureWrap wrap) {
  switch (wrap) {
  case TextureWrap::repeat: return u - std::floor(u);
  case TextureWrap::mirrored_repeat: return 1.0f - std::abs(1.0f - (u - 2.0f * std::floor(0.5f * u)));
  case TextureWrap::clamp_to_edge: break;
  }
  return std::clamp(u, 0.0f, 1.0f);
}

// Wraps an index that is at most one step outside. The mirror image of a texel at an edge is that
// texel.
int wrap_index(int index, int size, TextureWrap wrap) {
  if (wrap != TextureWrap::repeat) return std::clamp(index, 0, size - 1);
  return index < 0 ? index + size : index >= size ? index - size : index;
}

struct Axis {
  int low, high;
  float t;
};

// Returns the two texels around `unit` in [0, 1]; texel i has its center at (i + 0.5) / size.
template <bool kRepeats>
inline Axis locate_axis(float unit, int size, TextureWrap wrap) {
  const float x = unit * static_cast<float>(size) - 0.5f;
  const float cell = std::floor(x);
  const int low = static_cast<int>(cell);
  const int high = low + 1;
  if constexpr (kRepeats) return {low < 0 ? size - 1 : low, high >= size ? 0 : high, x - cell};
  return {wrap_index(low, size, wrap), wrap_index(high, size, wrap), x - cell};
}

inline Footprint make_footprint(const Axis& u, const Axis& v, int width) {
  const size_t top = static_cast<size_t>(v.low) * static_cast<size_t>(width);
  const size_t bottom = static_cast<size_t>(v.high) * static_cast<size_t>(width);
  const auto left = static_cast<size_t>(u.low), right = static_cast<size_t>(u.high);
  return {top + left, top + right, bottom + left, bottom + right, u.t, v.t};
}

int nearest_index(float unit, int size) {
  return std::min(static_cast<int>(unit * static_cast<float>(size)), size - 1);
}

// Bilinear interpolation, in a form that returns equal texels unchanged.
template <typename T>
inline T blend(const T& a, const T& b, const T& c, const T& d, float tx, float ty) {
  const T top = a + (b - a) * tx;
  const T bottom = c + (d - c) * tx;
  return top + (bottom - top) * ty;
}

} // namespace

// Look-ups, compiled once for each layout.
struct Texture::Lookup {
  static Footprint locate(const Texture& t, const Level& level, V2f uv) {
    if (!is_finite(uv)) uv = {0.0f, 0.0f};
    if (t.repeats_) {
      return make_footprint(locate_axis<true>(uv.x - std::floor(uv.x), level.width, TextureWrap::repeat),
                            locate_axis<true>(uv.y - std::floor(uv.y), level.height, TextureWrap::repeat), level.width);
    }
    return make_footprint(locate_axis<false>(wrap_coordinate(uv.x, t.wrap_u_), level.width, t.wrap_u_),
                          locate_axis<false>(wrap_coordinate(uv.y, t.wrap_v_), level.height, t.wrap_v_), level.width);
  }

  static size_t locate_nearest(const Texture& t, const Level& level, V2f uv) {
    if (!is_finite(uv)) uv = {0.0f, 0.0f};
    const int x = nearest_index(wrap_coordinate(uv.x, t.wrap_u_), level.width);
    const int y = nearest_index(wrap_coordinate(uv.y, t.wrap_v_), level.height);
    return static_cast<size_t>(y) * static_cast<size_t>(level.width) + static_cast<size_t>(x);
  }

  // Copies the four texels from pages, side by side.
  [[gnu::noinline]] static void fetch(const Texture& t, int level, const Footprint& f, std::byte* texels) {
    const auto width = static_cast<size_t>(t.levels_[static_cast<size_t>(level)].width);
    t.pages_->fetch(level, {static_cast<int>(f.top_left % width), static_cast<int>(f.top_right % width)},
                    {static_cast<int>(f.top_left / width), static_cast<int>(f.bottom_left / width)}, texels);
  }

  // Filters read(texel) by the filter of the texture.
  template <typename Reader, typename Read>
  static auto filter(const Texture& t, const V2f& uv, int number, const Read& read) {
    const Level& level = t.levels_[static_cast<size_t>(number)];
    const std::byte* pixels = level.pixels;
    std::array<std::byte, 4 * Reader::kBytes> fetched;
    const auto at = [&](size_t pixel) { return read(pixels + pixel * Reader::kBytes); };
    if (t.filter_ == TextureFilter::nearest && number == 0) {
      size_t pixel = locate_nearest(t, level, uv);
      if (!pixels) [[unlikely]] {
        fetch(t, number, {pixel, pixel, pixel, pixel, 0.0f, 0.0f}, fetched.data());
        pixels = fetched.data();
        pixel = 0;
      }
      return at(pixel);
    }
    Footprint f = locate(t, level, uv);
    if (!pixels) [[unlikely]] {
      fetch(t, number, f, fetched.data());
      pixels = fetched.data();
      f = {0, 1, 2, 3, f.tx, f.ty};
    }
    return blend(at(f.top_left), at(f.top_right), at(f.bottom_left), at(f.bottom_right), f.tx, f.ty);
  }

  // Returns RGB in the first three channels, and alpha in the last if the layout has one.
  template <typename Reader>
  static Float4 all(const Texture& t, const V2f& uv, int level) {
    return filter<Reader>(t, uv, level, [](const std::byte* texel) { return Reader::all(texel); }) * Reader::kScale;
  }

  template <typename Reader>
  static V4f sample(const Texture& t, const V2f& uv, int level) {
    const Float4 value = all<Reader>(t, uv, level);
    return {value[0], value[1], value[2], Reader::kHasAlpha ? value[3] : 1.0f};
  }

  template <typename Reader>
  static Rgb sample_rgb(const Texture& t, const V2f& uv, int level) {
    const Float4 value = all<Reader>(t, uv, level);
    return {value[0], value[1], value[2]};
  }

  template <typename Reader>
  static float sample_channel(const Texture& t, const V2f& uv, int channel, int level) {
    if (channel == 3 && !Reader::kHasAlpha) return 1.0f;
    const int stored = Reader::kChannelCount >= 3 ? channel : channel == 3 ? 1 : 0;
    return filter<Reader>(t, uv, level, [&](const std::byte* texel) { return Reader::channel(texel, stored); }) *
           Reader::kScale;
  }

  template <typename Reader>
  static bool is_opaque(const Texture& t) {
    if constexpr (Reader::kHasAlpha) {
      const Level& level = t.levels_[0];
      const size_t pixel_count = static_cast<size_t>(level.width) * static_cast<size_t>(level.height);
      for (size_t i = 0; i < pixel_count; ++i) {
        if (Reader::channel(level.pixels + i * Reader::kBytes, Reader::kChannelCount - 1) * Reader::kScale != 1.0f)
          return false;
      }
    }
    return true;
  }
};

Texture::Texture(const Image& format, const TextureSettings& settings)
    : texel_count_(static_cast<float>(format.width) * static_cast<float>(format.height)),
      layout_(make_layout(format.type, format.channels,
                          settings.encoding == TextureEncoding::srgb && is_integer(format.type))),
      pixel_bytes_(static_cast<uint8_t>(bytes_per_channel(format.type) * static_cast<size_t>(format.channels))),
      wrap_u_(settings.wrap_u), wrap_v_(settings.wrap_v), filter_(settings.filter),
      repeats_(wrap_u_ == TextureWrap::repeat && wrap_v_ == TextureWrap::repeat), has_alpha_(false) {
  assert(format.width > 0 && format.height > 0 && format.channels >= 1 && format.channels <= 4);
  levels_[0] = {nullptr, format.width, format.height};
}

Texture::Texture(std::shared_ptr<const Image> image, const TextureSettings& settings,
                 std::shared_ptr<const MipLevels> levels)
    : Texture(*image, settings) {
  assert(image->pixels.size() >= image->byte_count());
  image_ = std::move(image);
  mip_levels_ = std::move(levels);
  levels_[0].pixels = image_->pixels.data();
  if (mip_levels_) {
    for (const MipLevels::Level& level : mip_levels_->levels)
      levels_[static_cast<size_t>(level_count_++)] = {mip_levels_->pixels.data() + level.offset, level.width,
                                                      level.height};
    has_alpha_ = !mip_levels_->opaque;
  } else {
    static constexpr auto kIsOpaque = for_each_layout([]<typename Reader>() { return &Lookup::is_opaque<Reader>; });
    has_alpha_ = !kIsOpaque[layout_](*this);
  }
}

Texture::Texture(std::shared_ptr<const TiledImage> pages, const Image& format, const TextureSettings& settings,
                 const MipLevels& sizes)
    : Texture(format, settings) {
  pages_ = std::move(pages);
  for (const MipLevels::Level& level : sizes.levels)
    levels_[static_cast<size_t>(level_count_++)] = {nullptr, level.width, level.height};
  has_alpha_ = !sizes.opaque;
}

V4f Texture::sample(const V2f& uv, int level) const {
  assert(level >= 0 && level < level_count_);
  static constexpr auto kSample = for_each_layout([]<typename Reader>() { return &Lookup::sample<Reader>; });
  return kSample[layout_](*this, uv, level);
}

Rgb Texture::sample_rgb(const V2f& uv, int level) const {
  assert(level >= 0 && level < level_count_);
  static constexpr auto kSampleRgb = for_each_layout([]<typename Reader>() { return &Lookup::sample_rgb<Reader>; });
  return kSampleRgb[layout_](*this, uv, level);
}

float Texture::sample_channel(const V2f& uv, int channel, int level) const {
  assert(channel >= 0 && channel < 4 && level >= 0 && level < level_count_);
  static constexpr auto kSampleChannel =
      for_each_layout([]<typename Reader>() { return &Lookup::sample_channel<Reader>; });
  return kSampleChannel[layout_](*this, uv, channel, level);
}

// Prefetches the upper left of the four texels and the one below, with repeat wrapping. Their right
// neighbors are nearly always in the same cache lines. A wrong guess only wastes a request.
void Texture::prefetch(const V2f& uv, int level) const {
  assert(level >= 0 && level < level_count_);
  const Level& from = levels_[static_cast<size_t>(level)];
  if (!from.pixels || !is_finite(uv)) return; // tiles are not prefetched
  const auto x = static_cast<int>((uv.x - std::floor(uv.x)) * static_cast<float>(from.width) - 0.5f);
  const auto y = static_cast<int>((uv.y - std::floor(uv.y)) * static_cast<float>(from.height) - 0.5f);
  const size_t row_bytes = static_cast<size_t>(from.width) * pixel_bytes_;
  const std::byte* texel = from.pixels + static_cast<size_t>(y) * row_bytes + static_cast<size_t>(x) * pixel_bytes_;
  ::kindling::prefetch(texel);
  if (y + 1 < from.height) ::kindling::prefetch(texel + row_bytes);
}

Rgb Texture::average_rgb(const V2f& uv0, const V2f& uv1, const V2f& uv2) const {
  const V2f edge1 = uv1 - uv0, edge2 = uv2 - uv0;
  const double texels = 0.5 *
                        std::abs(static_cast<double>(edge1.x) * edge2.y - static_cast<double>(edge1.y) * edge2.x) *
                        levels_[0].width * levels_[0].height;
  // Two points for each texel, so that a small lamp in a large dark image is not missed.
  constexpr double kMinPoints = 16, kMaxPoints = 65536;
  const int count = static_cast<int>(texels > 0.0 ? std::clamp(2.0 * texels, kMinPoints, kMaxPoints) : kMinPoints);
  // The R2 sequence (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences") in
  // 32-bit fixed point, with its square folded onto the triangle.
  constexpr uint32_t kStep1 = 3242174889U, kStep2 = 2447445414U;
  double sum[3] = {};
  uint32_t x = 0x80000000U, y = 0x80000000U;
  for (int i = 0; i < count; ++i, x += kStep1, y += kStep2) {
    float a = static_cast<float>(x >> 8) * 0x1p-24f, b = static_cast<float>(y >> 8) * 0x1p-24f;
    if (a + b > 1.0f) {
      a = 1.0f - a;
      b = 1.0f - b;
    }
    const Rgb value = sample_rgb(uv0 + edge1 * a + edge2 * b);
    for (int c = 0; c < 3; ++c) sum[c] += value[c];
  }
  const double scale = 1.0 / count;
  return {static_cast<float>(sum[0] * scale), static_cast<float>(sum[1] * scale), static_cast<float>(sum[2] * scale)};
}

} // namespace kindling
