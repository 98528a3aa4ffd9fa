// Tests of mip levels against means in double precision, and of the selection of levels.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/mip_levels.h"

#include "renderer/texture/texture.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <random>

#include <half.h>

namespace kindling {
namespace {

constexpr std::array kMipTypes{PixelType::u8, PixelType::u16, PixelType::f16, PixelType::f32};
constexpr std::array kContents{TextureContent::data, TextureContent::color, TextureContent::cutout_color,
                               TextureContent::tangent_normal};

Image noise(int width, int height, int channels, PixelType type) {
  Image image{width, height, channels, type, {}};
  image.pixels.resize(image.byte_count());
  std::mt19937 random(static_cast<uint32_t>(width * 31 + height * 7 + channels));
  const size_t size = bytes_per_channel(type);
  for (size_t i = 0; i < image.pixels.size() / size; ++i) {
    const uint32_t bits = random();
    const float value = static_cast<float>(bits >> 8) * 0x1p-24f;
    const Imath::half half_value(value);
    const void* from = type == PixelType::f32   ? static_cast<const void*>(&value)
                       : type == PixelType::f16 ? static_cast<const void*>(&half_value)
                                                : &bits;
    std::memcpy(&image.pixels[i * size], from, size);
  }
  return image;
}

double to_linear(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }
double to_srgb(double v) { return v <= 0.0031308 ? v * 12.92 : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055; }

// Returns a stored value; integers are mapped to [0, 1].
double stored(const std::byte* pixels, PixelType type, size_t index) {
  uint16_t word = 0;
  float real = 0.0f;
  Imath::half half_value;
  switch (type) {
  case PixelType::u8: return static_cast<double>(pixels[index]) / 255.0;
  case PixelType::u16: std::memcpy(&word, pixels + index * 2, 2); return word / 65535.0;
  case PixelType::f16: std::memcpy(&half_value, pixels + index * 2, 2); return static_cast<float>(half_value);
  case PixelType::f32: std::memcpy(&real, pixels + index * 4, 4); return real;
  }
  return 0.0;
}

struct Plane {
  int width, height;
  std::vector<std::array<double, 4>> texels; // linear, weighted values
};

struct Kind {
  bool srgb, weighted, directions;
  int colors;
};

Kind kind_of(const Image& image, TextureContent content) {
  const bool integer = image.type == PixelType::u8 || image.type == PixelType::u16;
  const bool alpha = image.channels == 2 || image.channels == 4;
  return {integer && (content == TextureContent::color || content == TextureContent::cutout_color),
          alpha && content == TextureContent::cutout_color,
          content == TextureContent::tangent_normal && image.channels >= 3,
          alpha ? image.channels - 1 : image.channels};
}

Plane plane_of(const Image& image, const Kind& kind) {
  Plane plane{image.width, image.height, {}};
  plane.texels.resize(static_cast<size_t>(image.width) * static_cast<size_t>(image.height));
  const auto channels = static_cast<size_t>(image.channels);
  for (size_t i = 0; i < plane.texels.size(); ++i) {
    auto& t = plane.texels[i];
    for (size_t c = 0; c < channels; ++c) t[c] = stored(image.pixels.data(), image.type, i * channels + c);
    if (kind.srgb)
      for (int c = 0; c < kind.colors; ++c) t[static_cast<size_t>(c)] = to_linear(t[static_cast<size_t>(c)]);
    if (kind.directions) {
      const double x = 2 * t[0] - 1, y = 2 * t[1] - 1, z = 2 * t[2] - 1, length = std::sqrt(x * x + y * y + z * z);
      t[0] = x / length, t[1] = y / length, t[2] = z / length;
    }
    if (kind.weighted)
      for (int c = 0; c < kind.colors; ++c) t[static_cast<size_t>(c)] *= t[channels - 1];
  }
  return plane;
}

// Returns the next level: each texel is the mean over the rectangle that it covers.
Plane half_of(const Plane& from) {
  Plane to{std::max(from.width / 2, 1), std::max(from.height / 2, 1), {}};
  const double sx = static_cast<double>(from.width) / to.width, sy = static_cast<double>(from.height) / to.height;
  for (int y = 0; y < to.height; ++y)
    for (int x = 0; x < to.width; ++x) {
      std::array<double, 4> sum{};
      for (int v = 0; v < from.height; ++v)
        for (int u = 0; u < from.width; ++u) {
          const double w = std::max(0.0, std::min(u + 1.0, (x + 1) * sx) - std::max<double>(u, x * sx)) *
                           std::max(0.0, std::min(v + 1.0, (y + 1) * sy) - std::max<double>(v, y * sy));
          for (size_t c = 0; c < 4; ++c)
            sum[c] += w * from.texels[static_cast<size_t>(v * from.width + u)][c] / (sx * sy);
        }
      to.texels.push_back(sum);
    }
  return to;
}

// Half a step of the type, relative to [0, 1], and rounding in single precision.
double tolerance(PixelType type, double value) {
  switch (type) {
  case PixelType::u8: return 0.5 / 255 + 1e-6;
  case PixelType::u16: return 0.52 / 65535 + 1e-6; // the curve is interpolated between knots
  case PixelType::f16: return 0x1p-11 * value + 1e-6;
  case PixelType::f32: return 1e-6;
  }
  return 0.0;
}

void check(const Image& image, TextureContent content) {
  const Kind kind = kind_of(image, content);
  const MipLevels levels = build_mip_levels(image, content);
  Plane plane = plane_of(image, kind);
  const auto channels = static_cast<size_t>(image.channels);
  for (size_t l = 0; l < levels.levels.size(); ++l) {
    plane = half_of(plane);
    const MipLevels::Level& level = levels.levels[l];
    ASSERT_EQ(level.width, plane.width);
    ASSERT_EQ(level.height, plane.height);
    for (size_t i = 0; i < plane.texels.size(); ++i) {
      std::array<double, 4> mean = plane.texels[i];
      for (size_t c = 0; c < channels; ++c) {
        const bool color = static_cast<int>(c) < kind.colors;
        if (kind.weighted && color) mean[c] /= plane.texels[i][channels - 1];
        if (kind.directions && color) mean[c] = 0.5 * mean[c] + 0.5;
        if (kind.srgb && color) mean[c] = to_srgb(mean[c]);
        const double found = stored(levels.pixels.data() + level.offset, image.type, i * channels + c);
        // The weight of a texel is its alpha plus 1e-6.
        ASSERT_NEAR(found, mean[c], tolerance(image.type, mean[c]) + (kind.weighted ? 4e-6 : 0.0))
            << image.width << " x " << image.height << " x " << channels << " type " << static_cast<int>(image.type)
            << " content " << static_cast<int>(content) << " level " << l + 1 << " texel " << i << " channel " << c;
      }
    }
  }
  ASSERT_EQ(plane.texels.size(), 1u);
}

TEST(MipLevels, TexelsAreExactMeans) {
  for (const PixelType type : kMipTypes)
    for (int channels = 1; channels <= 4; ++channels)
      for (const TextureContent content : kContents) check(noise(12, 7, channels, type), content);
}

TEST(MipLevels, TexelsAreExactMeansForAnySize) {
  for (const auto& [width, height] : {std::pair{16, 16}, {1, 1}, {1, 9}, {33, 2}, {31, 17}, {2, 3}, {5, 64}}) {
    check(noise(width, height, 4, PixelType::u8), TextureContent::cutout_color);
    check(noise(width, height, 3, PixelType::f32), TextureContent::data);
  }
}

TEST(MipLevels, TransparentTexelsDoNotContributeColor) {
  Image image{4, 2, 4, PixelType::u8, {}};
  const uint8_t texels[] = {255, 0, 0, 255, 0, 255, 0, 0, 9, 99, 199, 0, 9, 99, 199, 0,
                            255, 0, 0, 255, 0, 255, 0, 0, 9, 99, 199, 0, 9, 99, 199, 0};
  image.pixels.resize(sizeof texels);
  std::memcpy(image.pixels.data(), texels, sizeof texels);
  const MipLevels levels = build_mip_levels(image, TextureContent::cutout_color);
  const std::array<uint8_t, 8> expected{255, 0, 0, 128, 9, 99, 199, 0};
  EXPECT_EQ(std::memcmp(levels.pixels.data(), expected.data(), expected.size()), 0);
  EXPECT_FALSE(levels.opaque);
  // Without coverage, alpha is an ordinary channel.
  const MipLevels plain = build_mip_levels(image, TextureContent::color);
  EXPECT_EQ(static_cast<int>(plain.pixels[0]), 188); // half the light
  EXPECT_EQ(static_cast<int>(plain.pixels[1]), 188);
  EXPECT_EQ(static_cast<int>(plain.pixels[3]), 128);
}

TEST(MipLevels, EncodersInvertDecoders) {
  for (int code = 0; code < 256; ++code) {
    EXPECT_EQ(encode_srgb_u8(decode_srgb_u8(static_cast<uint8_t>(code))), code);
    if (code == 255) continue;
    const double middle = decode_srgb((code + 0.5) / 255.0);
    EXPECT_EQ(encode_srgb_u8(static_cast<float>(middle * (1 - 1e-6))), code);
    EXPECT_EQ(encode_srgb_u8(static_cast<float>(middle * (1 + 1e-6))), code + 1);
  }
  for (int code = 0; code < 65536; ++code)
    ASSERT_EQ(encode_srgb_u16(decode_srgb_u16(static_cast<uint16_t>(code))), code);
  EXPECT_EQ(encode_srgb_u8(-1.0f), 0);
  EXPECT_EQ(encode_srgb_u8(2.0f), 255);
  EXPECT_EQ(encode_srgb_u8(std::nanf("")), 0);
}

TEST(MipLevels, LookUpsReadTheRequestedLevel) {
  const auto image = std::make_shared<Image>(noise(13, 10, 4, PixelType::u8));
  const auto levels = std::make_shared<MipLevels>(build_mip_levels(*image, TextureContent::color));
  const TextureSettings settings{.filter = TextureFilter::linear, .encoding = TextureEncoding::srgb};
  const Texture texture(image, settings, levels);
  ASSERT_EQ(texture.level_count, 4);
  for (int level = 1; level < 4; ++level) {
    const MipLevels::Level& from = levels->levels[static_cast<size_t>(level - 1)];
    auto alone = std::make_shared<Image>(Image{from.width, from.height, 4, PixelType::u8, {}});
    alone->pixels.assign(levels->pixels.begin() + static_cast<std::ptrdiff_t>(from.offset),
                         levels->pixels.begin() + static_cast<std::ptrdiff_t>(from.offset + alone->byte_count()));
    const Texture expected(alone, settings);
    for (int i = 0; i < 50; ++i) {
      const V2f uv(0.37f * static_cast<float>(i) - 3.0f, 0.23f * static_cast<float>(i));
      EXPECT_EQ(texture.sample(uv, level), expected.sample(uv));
      EXPECT_EQ(texture.sample_rgb(uv, level), expected.sample_rgb(uv));
      EXPECT_EQ(texture.sample_channel(uv, 3, level), expected.sample_channel(uv, 3));
    }
  }
}

TEST(MipLevels, LevelFollowsWidthOfFootprint) {
  const auto image = std::make_shared<Image>(noise(64, 64, 1, PixelType::u8));
  const Texture texture(image, {}, std::make_shared<MipLevels>(build_mip_levels(*image, TextureContent::data)));
  const auto share_above = [&](double width_texels, int level) {
    constexpr int kDraws = 4096;
    int above = 0;
    for (int i = 0; i < kDraws; ++i)
      above += texture.choose_level(static_cast<float>(width_texels * width_texels / 4096),
                                    (static_cast<float>(i) + 0.5f) / kDraws) > level;
    return static_cast<double>(above) / kDraws;
  };
  EXPECT_EQ(share_above(0.0, 0), 0.0);
  EXPECT_EQ(share_above(1.0, 0), 0.0);
  for (const double log2_width : {0.1, 0.25, 0.5, 0.9}) {
    EXPECT_NEAR(share_above(std::exp2(log2_width), 0), log2_width, 0.05);
    EXPECT_NEAR(share_above(std::exp2(3 + log2_width), 3), log2_width, 0.05);
  }
  EXPECT_EQ(share_above(8.0, 2), 1.0);
  EXPECT_EQ(share_above(8.0, 3), 0.0);
  EXPECT_EQ(texture.choose_level(std::numeric_limits<float>::infinity(), 0.999f), 6);
  EXPECT_EQ(texture.choose_level(std::nanf(""), 0.999f), 0);
}

} // namespace
} // namespace kindling
