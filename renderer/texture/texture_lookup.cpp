// Texture look-ups: wrapping, fetching, decoding and filtering of texels.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/texture.h"

#include "renderer/base/on_gpu.h"
#include "renderer/base/prefetch.h"
#include "renderer/texture/any_texel_reader.h"
#include "renderer/texture/layouts.h"
#include "renderer/texture/texel_fetch.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace kindling {

namespace {

using texture_detail::AnyTexelReader;
using texture_detail::with_layout;

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

// Look-ups with a reader of the texture's layout.
template <typename Reader>
struct Lookup {
  using Level = TextureView::Level;

  [[nodiscard]] Footprint locate(const Level& level, V2f uv) const {
    if (!is_finite(uv)) uv = {0.0f, 0.0f};
    if (texture.repeats) {
      return make_footprint(locate_axis<true>(uv.x - std::floor(uv.x), level.width, TextureWrap::repeat),
                            locate_axis<true>(uv.y - std::floor(uv.y), level.height, TextureWrap::repeat), level.width);
    }
    return make_footprint(locate_axis<false>(wrap_coordinate(uv.x, texture.wrap_u), level.width, texture.wrap_u),
                          locate_axis<false>(wrap_coordinate(uv.y, texture.wrap_v), level.height, texture.wrap_v),
                          level.width);
  }

  [[nodiscard]] size_t locate_nearest(const Level& level, V2f uv) const {
    if (!is_finite(uv)) uv = {0.0f, 0.0f};
    const int x = nearest_index(wrap_coordinate(uv.x, texture.wrap_u), level.width);
    const int y = nearest_index(wrap_coordinate(uv.y, texture.wrap_v), level.height);
    return static_cast<size_t>(y) * static_cast<size_t>(level.width) + static_cast<size_t>(x);
  }

  // Copies the four texels from pages, side by side.
  void fetch(int level, const Footprint& f, std::byte* texels) const {
    const auto width = static_cast<size_t>(texture.levels[static_cast<size_t>(level)].width);
    texture.fetch(level, {static_cast<int>(f.top_left % width), static_cast<int>(f.top_right % width)},
                  {static_cast<int>(f.top_left / width), static_cast<int>(f.bottom_left / width)}, texels);
  }

  // Filters read(texel) by the filter of the texture.
  template <typename Read>
  [[nodiscard]] auto filter(const V2f& uv, int number, const Read& read) const {
    const Level& level = texture.levels[static_cast<size_t>(number)];
    const std::byte* pixels = level.pixels;
    std::array<std::byte, 4 * Reader::kMaxBytes> fetched;
    const auto at = [&](size_t pixel) {
      const std::byte* texel = pixels + pixel * reader.bytes();
      if (KINDLING_ON_GPU && !pixels) [[unlikely]] // in place, since copies would need a stack
        texel = texture.tiles->texel(number, pixel, texture.pixel_bytes);
      return read(texel);
    };
    if (texture.filter == TextureFilter::nearest && number == 0) {
      size_t pixel = locate_nearest(level, uv);
      if (!KINDLING_ON_GPU && !pixels) [[unlikely]] {
        fetch(number, {pixel, pixel, pixel, pixel, 0.0f, 0.0f}, fetched.data());
        pixels = fetched.data();
        pixel = 0;
      }
      return at(pixel);
    }
    Footprint f = locate(level, uv);
    if (!KINDLING_ON_GPU && !pixels) [[unlikely]] {
      fetch(number, f, fetched.data());
      pixels = fetched.data();
      f = {0, 1, 2, 3, f.tx, f.ty};
    }
    return blend(at(f.top_left), at(f.top_right), at(f.bottom_left), at(f.bottom_right), f.tx, f.ty);
  }

  // Returns RGB in the first three channels, and alpha in the last if the layout has one.
  [[nodiscard]] Float4 all(const V2f& uv, int level) const {
    return filter(uv, level, [this](const std::byte* texel) { return reader.all(texel); }) * reader.scale();
  }

  [[nodiscard]] V4f sample(const V2f& uv, int level) const {
    const Float4 value = all(uv, level);
    return {value[0], value[1], value[2], reader.has_alpha() ? value[3] : 1.0f};
  }

  [[nodiscard]] Rgb sample_rgb(const V2f& uv, int level) const {
    const Float4 value = all(uv, level);
    return {value[0], value[1], value[2]};
  }

  [[nodiscard]] float sample_channel(const V2f& uv, int channel, int level) const {
    if (channel == 3 && !reader.has_alpha()) return 1.0f;
    const int stored = reader.channel_count() >= 3 ? channel : channel == 3 ? 1 : 0;
    return filter(uv, level, [&](const std::byte* texel) { return reader.channel(texel, stored); }) * reader.scale();
  }

  void alphas_of_row(int row, std::span<float> alphas) const {
    const Level& level = texture.levels[0];
    const std::byte* texel =
        level.pixels + static_cast<size_t>(row) * static_cast<size_t>(level.width) * reader.bytes();
    for (float& alpha : alphas) {
      alpha = reader.has_alpha() ? reader.channel(texel, reader.channel_count() - 1) * reader.scale() : 1.0f;
      texel += reader.bytes();
    }
  }

  const TextureView& texture;
  Reader reader;
};

// Returns f(look-up), with one instance of f for each layout; on a GPU with one for all, whose code
// is 40 times shorter.
template <typename F>
[[gnu::always_inline]] inline auto with_lookup(const TextureView& texture, const F& f) {
#if KINDLING_ON_GPU
  return f(Lookup<AnyTexelReader>{texture, AnyTexelReader(texture.layout)});
#else
  return with_layout(texture.layout, [&]<typename Reader>() { return f(Lookup<Reader>{texture, {}}); });
#endif
}

} // namespace

V4f TextureView::sample(const V2f& uv, int level) const {
  assert(level >= 0 && level < level_count);
  return with_lookup(*this, [&](const auto& lookup) { return lookup.sample(uv, level); });
}

Rgb TextureView::sample_rgb(const V2f& uv, int level) const {
  assert(level >= 0 && level < level_count);
  return with_lookup(*this, [&](const auto& lookup) { return lookup.sample_rgb(uv, level); });
}

float TextureView::sample_channel(const V2f& uv, int channel, int level) const {
  assert(channel >= 0 && channel < 4 && level >= 0 && level < level_count);
  return with_lookup(*this, [&](const auto& lookup) { return lookup.sample_channel(uv, channel, level); });
}

void TextureView::alphas_of_row(int row, std::span<float> alphas) const {
  assert(levels[0].pixels && row >= 0 && row < levels[0].height &&
         alphas.size() == static_cast<size_t>(levels[0].width));
  with_lookup(*this, [&](const auto& lookup) { lookup.alphas_of_row(row, alphas); });
}

// Prefetches the upper left of the four texels and the one below, with repeat wrapping. Their right
// neighbors are nearly always in the same cache lines. A wrong guess only wastes a request.
void TextureView::prefetch(const V2f& uv, int level) const {
  assert(level >= 0 && level < level_count);
  const Level& from = levels[static_cast<size_t>(level)];
  if (!from.pixels || !is_finite(uv)) return; // tiles are not prefetched
  const auto x = static_cast<int>((uv.x - std::floor(uv.x)) * static_cast<float>(from.width) - 0.5f);
  const auto y = static_cast<int>((uv.y - std::floor(uv.y)) * static_cast<float>(from.height) - 0.5f);
  const size_t row_bytes = static_cast<size_t>(from.width) * pixel_bytes;
  const std::byte* texel = from.pixels + static_cast<size_t>(y) * row_bytes + static_cast<size_t>(x) * pixel_bytes;
  ::kindling::prefetch(texel);
  if (y + 1 < from.height) ::kindling::prefetch(texel + row_bytes);
}

} // namespace kindling
