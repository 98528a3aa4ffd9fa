// Construction of mip levels in one pass: rows of the image complete rows of all levels below.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/mip_levels.h"

#include "renderer/texture/layouts.h"
#include "renderer/texture/texel_fetch.h"
#include "renderer/texture/texel_store.h"

#include <algorithm>
#include <cmath>

namespace kindling {
namespace {

using texture_detail::make_layout;
using texture_detail::store_texel;
using texture_detail::with_layout;

// Weight of a texel beyond its alpha, so that the color of a fully transparent mean is the plain
// mean.
constexpr float kMinWeight = 0x1p-20f;

// Returns the overlap of texel `index` of a level of `size` texels with texel `other` of a level of
// `next` texels, on one axis and in common units: of [index * next, (index + 1) * next) with
// [other * size, (other + 1) * size).
float overlap(int index, int other, int size, int next) {
  const int64_t begin = std::max(int64_t{index} * next, int64_t{other} * size);
  const int64_t end = std::min(int64_t{index + 1} * next, int64_t{other + 1} * size);
  return static_cast<float>(std::max<int64_t>(end - begin, 0));
}

// Conversion of rows of texels to and from linear values, a pair of functions for each layout.
struct RowCode {
  void (*decode)(const std::byte* texels, size_t count, Float4* out);
  void (*encode)(const Float4* row, size_t count, std::byte* texels);
};

template <typename Reader>
void decode_row(const std::byte* texels, size_t count, Float4* out) {
  for (size_t x = 0; x < count; ++x) out[x] = Reader::all(texels + x * Reader::kBytes) * Reader::kScale;
}

template <typename Reader>
void encode_row(const Float4* row, size_t count, std::byte* texels) {
  for (size_t x = 0; x < count; ++x) store_texel<Reader>(row[x], texels + x * Reader::kBytes);
}

RowCode row_code(const Image& format, TextureContent content) {
  const bool color = content == TextureContent::color || content == TextureContent::cutout_color;
  return with_layout(make_layout(format.type, format.channels, color && texture_detail::is_integer(format.type)),
                     []<typename Reader>() {
                       return RowCode{&decode_row<Reader>, &encode_row<Reader>};
                     });
}

class Pyramid {
 public:
  Pyramid(const Image& format, TextureContent content, MipLevels& result)
      : code_(row_code(format, content)), has_alpha_(format.channels == 2 || format.channels == 4),
        weigh_by_alpha_(content == TextureContent::cutout_color && has_alpha_),
        directions_(content == TextureContent::tangent_normal && format.channels >= 3),
        texel_bytes_(bytes_per_channel(format.type) * static_cast<size_t>(format.channels)), result_(result) {
    int width = format.width, height = format.height;
    stages_.push_back({width, height, {}, {}, {}});
    size_t bytes = 0;
    while (width > 1 || height > 1) {
      width = std::max(width / 2, 1);
      height = std::max(height / 2, 1);
      result_.levels.push_back({width, height, bytes});
      bytes += static_cast<size_t>(width) * static_cast<size_t>(height) * texel_bytes_;
      stages_.push_back({width, height, {}, {}, {}});
    }
    result_.pixels.resize(bytes);
    for (size_t level = 0; level + 1 < stages_.size(); ++level) {
      Stage& stage = stages_[level];
      const auto next = static_cast<size_t>(stages_[level + 1].width);
      stage.reduced.resize(next);
      stage.sum.assign(next, Float4{});
      stage.carried.assign(next, Float4{});
    }
    row_.resize(static_cast<size_t>(format.width));
    stored_.resize(row_.size());
  }

  void push_image_row(int y, const std::byte* texels) {
    code_.decode(texels, row_.size(), row_.data());
    if (has_alpha_)
      result_.opaque &= std::all_of(row_.begin(), row_.end(), [](const Float4& t) { return t[3] == 1.0f; });
    if (weigh_by_alpha_) {
      for (Float4& texel : row_) {
        const float weight = texel[3] + kMinWeight;
        texel = Float4{texel[0] * weight, texel[1] * weight, texel[2] * weight, weight};
      }
    }
    if (directions_) {
      for (Float4& texel : row_) texel = unit_direction(texel);
    }
    push(0, y, row_.data());
  }

 private:
  struct Stage {
    int width, height;
    std::vector<Float4> reduced; // the current row at the width of the next level
    std::vector<Float4> sum;     // partial row of the next level
    std::vector<Float4> carried; // the part of the current row that belongs to the row after that
  };

  static Float4 unit_direction(const Float4& texel) {
    const float x = 2.0f * texel[0] - 1.0f, y = 2.0f * texel[1] - 1.0f, z = 2.0f * texel[2] - 1.0f;
    const float length2 = x * x + y * y + z * z;
    const float scale = length2 > 0.0f ? 1.0f / std::sqrt(length2) : 0.0f;
    return Float4{x * scale, y * scale, z * scale, texel[3]};
  }

  // Reduces a row to the width of the next level by exact box filtering.
  static void reduce_row(const Float4* row, int width, int next, Float4* out) {
    if (width == next) {
      std::copy_n(row, width, out);
    } else if (width == 2 * next) {
      for (int x = 0; x < next; ++x) out[x] = (row[2 * x] + row[2 * x + 1]) * 0.5f;
    } else { // width = 2 next + 1: a texel of the next level covers 2 + 1 / next texels
      const float scale = 1.0f / static_cast<float>(width);
      for (int x = 0; x < next; ++x) {
        const auto first = static_cast<float>(next - x), last = static_cast<float>(x + 1);
        out[x] = (row[2 * x] * first + row[2 * x + 1] * static_cast<float>(next) + row[2 * x + 2] * last) * scale;
      }
    }
  }

  void push(size_t level, int y, const Float4* row) {
    Stage& stage = stages_[level];
    if (level > 0) store_row(result_.levels[level - 1], y, row);
    if (level + 1 == stages_.size()) return;
    const Stage& next = stages_[level + 1];
    reduce_row(row, stage.width, next.width, stage.reduced.data());
    const auto first = static_cast<int>(int64_t{y} * next.height / stage.height);
    const float scale = 1.0f / static_cast<float>(stage.height);
    const float weight = overlap(y, first, stage.height, next.height) * scale;
    const float rest = overlap(y, first + 1, stage.height, next.height) * scale;
    for (size_t x = 0; x < stage.sum.size(); ++x) stage.sum[x] += stage.reduced[x] * weight;
    if (rest > 0.0f) {
      for (size_t x = 0; x < stage.sum.size(); ++x) stage.carried[x] = stage.reduced[x] * rest;
    }
    if (int64_t{y + 1} * next.height < int64_t{first + 1} * stage.height) return;
    push(level + 1, first, stage.sum.data());
    if (rest > 0.0f)
      stage.sum.swap(stage.carried);
    else
      std::fill(stage.sum.begin(), stage.sum.end(), Float4{});
  }

  void store_row(const MipLevels::Level& level, int y, const Float4* row) {
    const auto count = static_cast<size_t>(level.width);
    std::byte* out = result_.pixels.data() + level.offset + static_cast<size_t>(y) * count * texel_bytes_;
    if (!weigh_by_alpha_ && !directions_) {
      code_.encode(row, count, out);
      return;
    }
    for (size_t x = 0; x < count; ++x) {
      const Float4& sum = row[x];
      if (directions_) {
        stored_[x] = Float4{0.5f * sum[0] + 0.5f, 0.5f * sum[1] + 0.5f, 0.5f * sum[2] + 0.5f, sum[3]};
      } else {
        const float scale = 1.0f / sum[3];
        stored_[x] = Float4{sum[0] * scale, sum[1] * scale, sum[2] * scale, sum[3] - kMinWeight};
      }
    }
    code_.encode(stored_.data(), count, out);
  }

  RowCode code_;
  bool has_alpha_;
  bool weigh_by_alpha_;
  bool directions_;
  size_t texel_bytes_;
  MipLevels& result_;
  std::vector<Stage> stages_;
  std::vector<Float4> row_;
  std::vector<Float4> stored_;
};

} // namespace

MipLevels build_mip_levels(const Image& format, TextureContent content, const ReadRow& read_row) {
  MipLevels result;
  Pyramid pyramid(format, content, result);
  for (int y = 0; y < format.height; ++y) pyramid.push_image_row(y, read_row(y));
  return result;
}

MipLevels build_mip_levels(const Image& image, TextureContent content) {
  const size_t row_bytes = image.byte_count() / static_cast<size_t>(image.height);
  return build_mip_levels(image, content,
                          [&](int row) { return image.pixels.data() + static_cast<size_t>(row) * row_bytes; });
}

} // namespace kindling
