// Tests of texture look-ups against a double-precision reference, for all layouts and settings.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/texture.h"

#include "renderer/texture/srgb.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <string>

#include <half.h>

namespace kindling {
namespace {

constexpr std::array kTypes{PixelType::u8, PixelType::u16, PixelType::f16, PixelType::f32};
constexpr std::array kWraps{TextureWrap::repeat, TextureWrap::mirrored_repeat, TextureWrap::clamp_to_edge};

// The vector has no spare bytes, so that the address sanitizer detects a read past the last texel.
std::shared_ptr<Image> make_noise(int width, int height, int channels, PixelType type, uint32_t seed = 1) {
  auto image = std::make_shared<Image>(Image{width, height, channels, type, {}});
  image->pixels.resize(image->byte_count());
  image->pixels.shrink_to_fit();
  std::mt19937 random(seed);
  const size_t size = bytes_per_channel(type);
  for (size_t i = 0; i < image->pixels.size() / size; ++i) {
    const uint32_t bits = random();
    const float value = static_cast<float>(bits >> 8) * 0x1p-22f;
    const Imath::half half_value(value);
    const void* from = type == PixelType::f32   ? static_cast<const void*>(&value)
                       : type == PixelType::f16 ? static_cast<const void*>(&half_value)
                                                : &bits;
    std::memcpy(&image->pixels[i * size], from, size);
  }
  return image;
}

std::shared_ptr<Image> make_u8(int width, int height, int channels, const std::vector<int>& values) {
  auto image = std::make_shared<Image>(Image{width, height, channels, PixelType::u8, {}});
  for (const int value : values) image->pixels.push_back(static_cast<std::byte>(value));
  return image;
}

// ---- reference implementation

double stored_channel(const Image& image, int x, int y, int channel, bool srgb) {
  const size_t size = bytes_per_channel(image.type);
  const size_t at = ((static_cast<size_t>(y) * static_cast<size_t>(image.width) + static_cast<size_t>(x)) *
                         static_cast<size_t>(image.channels) +
                     static_cast<size_t>(channel)) *
                    size;
  const auto decode = [&](double value) {
    if (!srgb) return value;
    return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
  };
  uint16_t word = 0;
  float real = 0.0f;
  Imath::half half_value;
  switch (image.type) {
  case PixelType::u8: return decode(static_cast<double>(image.pixels[at]) / 255.0);
  case PixelType::u16: std::memcpy(&word, &image.pixels[at], 2); return decode(word / 65535.0);
  case PixelType::f16: std::memcpy(&half_value, &image.pixels[at], 2); return static_cast<double>(half_value);
  case PixelType::f32: std::memcpy(&real, &image.pixels[at], 4); return real;
  }
  return 0.0;
}

// Returns channel `c` of RGBA.
double reference_texel(const Image& image, int x, int y, int c, TextureEncoding encoding) {
  const bool has_alpha = image.channels == 2 || image.channels == 4;
  if (c == 3) return has_alpha ? stored_channel(image, x, y, image.channels - 1, false) : 1.0;
  return stored_channel(image, x, y, image.channels >= 3 ? c : 0, encoding == TextureEncoding::srgb);
}

// Maps an index to a texel, step by step.
int reference_wrap(long long index, int size, TextureWrap wrap) {
  const auto modulo = [](long long a, long long b) { return ((a % b) + b) % b; };
  switch (wrap) {
  case TextureWrap::repeat: return static_cast<int>(modulo(index, size));
  case TextureWrap::mirrored_repeat: {
    const long long i = modulo(index, 2LL * size);
    return static_cast<int>(i < size ? i : 2LL * size - 1 - i);
  }
  case TextureWrap::clamp_to_edge: break;
  }
  return static_cast<int>(std::clamp<long long>(index, 0, size - 1));
}

std::array<double, 4> reference_sample(const Image& image, const TextureSettings& settings, double u, double v) {
  std::array<double, 4> result{};
  const auto texel = [&](long long x, long long y, int c) {
    return reference_texel(image, reference_wrap(x, image.width, settings.wrap_u),
                           reference_wrap(y, image.height, settings.wrap_v), c, settings.encoding);
  };
  for (int c = 0; c < 4; ++c) {
    if (settings.filter == TextureFilter::nearest) {
      result[static_cast<size_t>(c)] = texel(static_cast<long long>(std::floor(u * image.width)),
                                             static_cast<long long>(std::floor(v * image.height)), c);
      continue;
    }
    const double x = u * image.width - 0.5, y = v * image.height - 0.5;
    const auto x0 = static_cast<long long>(std::floor(x)), y0 = static_cast<long long>(std::floor(y));
    const double tx = x - static_cast<double>(x0), ty = y - static_cast<double>(y0);
    result[static_cast<size_t>(c)] = (1 - ty) * ((1 - tx) * texel(x0, y0, c) + tx * texel(x0 + 1, y0, c)) +
                                     ty * ((1 - tx) * texel(x0, y0 + 1, c) + tx * texel(x0 + 1, y0 + 1, c));
  }
  return result;
}

// Checks all three look-up functions. `tolerance` is relative to the maximum value of 4.
void expect_sample(const Texture& texture, const Image& image, const TextureSettings& settings, const V2f& uv,
                   double tolerance) {
  const auto expected = reference_sample(image, settings, uv.x, uv.y);
  const V4f all = texture.sample(uv);
  const Rgb rgb = texture.sample_rgb(uv);
  for (int c = 0; c < 4; ++c) {
    ASSERT_NEAR(all[c], expected[static_cast<size_t>(c)], tolerance)
        << "channel " << c << " at " << uv << ", " << image.channels << " channels of type "
        << static_cast<int>(image.type);
    EXPECT_NEAR(texture.sample_channel(uv, c), all[c], 1e-6);
    if (c < 3) {
      EXPECT_EQ(rgb[c], all[c]);
    }
  }
}

// ---- look-ups

// A coordinate of up to 8 in single precision has an error of at most 2^-22, times 37 texels:
// 37 * 2^-22 of a step of 4.
TEST(Texture, BilinearMatchesTheReference) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> coordinate(-3.0f, 4.0f);
  for (const PixelType type : kTypes) {
    for (int channels = 1; channels <= 4; ++channels) {
      for (const TextureEncoding encoding : {TextureEncoding::linear, TextureEncoding::srgb}) {
        const auto image = make_noise(37, 16, channels, type);
        const bool is_float = type == PixelType::f16 || type == PixelType::f32;
        for (const TextureWrap wrap_u : kWraps) {
          for (const TextureWrap wrap_v : kWraps) {
            const TextureSettings settings{wrap_u, wrap_v, TextureFilter::linear, encoding};
            const Texture texture(image, settings);
            TextureSettings meant = settings;
            if (is_float) meant.encoding = TextureEncoding::linear; // floats are always linear
            for (int i = 0; i < 50; ++i) {
              expect_sample(texture, *image, meant, {coordinate(random), coordinate(random)}, is_float ? 1e-4 : 3e-5);
            }
          }
        }
      }
    }
  }
}

// Points at the borders between texels are excluded, where rounding may choose either texel.
TEST(Texture, NearestMatchesTheReference) {
  std::mt19937 random(12);
  for (const PixelType type : kTypes) {
    for (int channels = 1; channels <= 4; ++channels) {
      const auto image = make_noise(7, 5, channels, type);
      for (const TextureWrap wrap : kWraps) {
        const TextureSettings settings{wrap, wrap, TextureFilter::nearest, TextureEncoding::linear};
        const Texture texture(image, settings);
        for (int i = 0; i < 100; ++i) {
          const auto left = static_cast<float>(static_cast<int>(random() % 40) - 20);
          const auto x = left + 0.1f + 0.8f * static_cast<float>(random() % 100) * 0.01f;
          const auto y = static_cast<float>(static_cast<int>(random() % 40) - 20) + 0.5f;
          expect_sample(texture, *image, settings, {x / 7.0f, y / 5.0f}, 1e-6);
        }
      }
    }
  }
}

TEST(Texture, TexelCentersGiveExactTexels) {
  for (const PixelType type : kTypes) {
    for (int channels = 1; channels <= 4; ++channels) {
      // With sizes that are powers of two, centers have exact coordinates.
      const auto image = make_noise(16, 8, channels, type);
      for (const TextureWrap wrap : kWraps) {
        for (const TextureFilter filter : {TextureFilter::nearest, TextureFilter::linear}) {
          const Texture texture(image, {wrap, wrap, filter, TextureEncoding::linear});
          for (int y = 0; y < 8; ++y) {
            for (int x = 0; x < 16; ++x) {
              const V4f value =
                  texture.sample({(static_cast<float>(x) + 0.5f) / 16.0f, (static_cast<float>(y) + 0.5f) / 8.0f});
              for (int c = 0; c < 4; ++c) {
                EXPECT_FLOAT_EQ(value[c],
                                static_cast<float>(reference_texel(*image, x, y, c, TextureEncoding::linear)));
              }
            }
          }
        }
      }
    }
  }
}

TEST(Texture, FirstTexelIsTopLeft) {
  const Texture texture(make_u8(2, 2, 1, {0, 51, 102, 255}),
                        {TextureWrap::repeat, TextureWrap::repeat, TextureFilter::nearest, {}});
  EXPECT_FLOAT_EQ(texture.sample_channel({0.1f, 0.1f}, 0), 0.0f);
  EXPECT_FLOAT_EQ(texture.sample_channel({0.9f, 0.1f}, 0), 0.2f);
  EXPECT_FLOAT_EQ(texture.sample_channel({0.1f, 0.9f}, 0), 0.4f);
  EXPECT_FLOAT_EQ(texture.sample_channel({0.9f, 0.9f}, 0), 1.0f);
}

// Values at the seams of each wrap mode, for a row of 0, 51, 102, 255.
TEST(Texture, WrapModesHaveExpectedSeams) {
  const auto image = make_u8(4, 1, 1, {0, 51, 102, 255});
  const auto at = [&](TextureWrap wrap, TextureFilter filter, float u) {
    return Texture(image, {wrap, wrap, filter, TextureEncoding::linear}).sample_channel({u, 0.5f}, 0);
  };
  using enum TextureWrap;
  for (const float u : {0.0f, 1.0f, -1.0f, 2.0f, -7.0f})
    EXPECT_FLOAT_EQ(at(repeat, TextureFilter::linear, u), 0.5f) << u;
  // Even integers are between the first texel and its mirror image, odd ones between the last texel
  // and its mirror image.
  for (const float u : {0.0f, 2.0f, -2.0f}) EXPECT_FLOAT_EQ(at(mirrored_repeat, TextureFilter::linear, u), 0.0f) << u;
  for (const float u : {1.0f, -1.0f, 3.0f}) EXPECT_FLOAT_EQ(at(mirrored_repeat, TextureFilter::linear, u), 1.0f) << u;
  EXPECT_FLOAT_EQ(at(mirrored_repeat, TextureFilter::linear, -0.375f), 0.2f);
  EXPECT_FLOAT_EQ(at(mirrored_repeat, TextureFilter::linear, 1.375f), 0.4f);
  for (const float u : {-100.0f, -0.01f, 0.0f, 0.125f})
    EXPECT_FLOAT_EQ(at(clamp_to_edge, TextureFilter::linear, u), 0.0f) << u;
  for (const float u : {0.875f, 1.0f, 1.5f, 1e30f})
    EXPECT_FLOAT_EQ(at(clamp_to_edge, TextureFilter::linear, u), 1.0f) << u;
  // Nearest filtering just inside and just outside.
  EXPECT_FLOAT_EQ(at(repeat, TextureFilter::nearest, -1e-10f), 1.0f);
  EXPECT_FLOAT_EQ(at(repeat, TextureFilter::nearest, 1.0f), 0.0f);
  EXPECT_FLOAT_EQ(at(repeat, TextureFilter::nearest, kOneMinusEpsilon), 1.0f);
  EXPECT_FLOAT_EQ(at(mirrored_repeat, TextureFilter::nearest, 1.0f), 1.0f);
  EXPECT_FLOAT_EQ(at(mirrored_repeat, TextureFilter::nearest, -1e-10f), 0.0f);
  EXPECT_FLOAT_EQ(at(clamp_to_edge, TextureFilter::nearest, 1.0f), 1.0f);
}

// No read is out of bounds (checked by the address sanitizer), and all values are finite.
TEST(Texture, AcceptsHugeAndNonFiniteCoordinates) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const int size : {1, 3, 16}) {
    for (const TextureWrap wrap : kWraps) {
      for (const TextureFilter filter : {TextureFilter::nearest, TextureFilter::linear}) {
        const Texture texture(make_noise(size, size, 3, PixelType::u8), {wrap, wrap, filter, TextureEncoding::srgb});
        const Rgb origin = texture.sample_rgb({0.0f, 0.0f});
        for (const V2f& uv :
             {V2f(nan, 0.3f), V2f(0.3f, nan), V2f(kInfinity, 0.3f), V2f(0.3f, -kInfinity), V2f(nan, kInfinity)}) {
          EXPECT_EQ(texture.sample_rgb(uv), origin) << uv;
        }
        for (const float big : {1e6f, 16777217.0f, 1e9f, 2147483648.0f, 1e20f, std::numeric_limits<float>::max()}) {
          for (const V2f& uv : {V2f(big, -big), V2f(-big, 0.7f), V2f(0.7f, big)}) {
            const V4f value = texture.sample(uv);
            for (int c = 0; c < 4; ++c) {
              EXPECT_GE(value[c], 0.0f);
              EXPECT_LE(value[c], 1.0f);
            }
          }
        }
      }
    }
  }
}

// Tests coordinates at and next to every border between texels, over several repeats.
TEST(Texture, BordersStayInBounds) {
  for (const int size : {1, 2, 3, 5, 4096, 32768}) {
    const auto image = std::make_shared<Image>(
        Image{size, 1, 1, PixelType::u8, std::vector<std::byte>(static_cast<size_t>(size), std::byte{255})});
    for (const TextureWrap wrap : kWraps) {
      for (const TextureFilter filter : {TextureFilter::nearest, TextureFilter::linear}) {
        const Texture texture(image, {wrap, wrap, filter, TextureEncoding::linear});
        for (int i = -8; i <= 8; ++i) {
          const float border = static_cast<float>(i) / static_cast<float>(std::min(size, 4));
          for (const float u : {border, std::nextafter(border, -9.0f), std::nextafter(border, 9.0f)}) {
            ASSERT_EQ(texture.sample({u, u}), V4f(1.0f)) << u << " of " << size; // exact, because the image is constant
          }
        }
      }
    }
  }
}

TEST(Texture, OneTexelIsConstant) {
  const auto image = make_u8(1, 1, 4, {255, 51, 0, 102});
  for (const TextureWrap wrap : kWraps) {
    for (const TextureFilter filter : {TextureFilter::nearest, TextureFilter::linear}) {
      const Texture texture(image, {wrap, wrap, filter, TextureEncoding::linear});
      for (const V2f& uv : {V2f(0.0f), V2f(0.5f), V2f(1.0f), V2f(-7.3f, 12.8f)}) {
        EXPECT_EQ(texture.sample(uv), V4f(1.0f, 51.0f * (1.0f / 255.0f), 0.0f, 102.0f * (1.0f / 255.0f)));
      }
    }
  }
}

// ---- encoding and alpha

TEST(Texture, SrgbTablesMatchStandardCurve) {
  for (int i = 0; i < 256; ++i) {
    const double x = i / 255.0;
    const double expected = x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
    EXPECT_FLOAT_EQ(decode_srgb_u8(static_cast<uint8_t>(i)), static_cast<float>(expected));
  }
  EXPECT_EQ(decode_srgb_u8(255), 1.0f);
  EXPECT_EQ(decode_srgb_u16(0), 0.0f);
  EXPECT_EQ(decode_srgb_u16(65535), 1.0f);
  float last = -1.0f;
  for (int i = 0; i < 65536; ++i) {
    const double x = i / 65535.0;
    const double expected = x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
    const float value = decode_srgb_u16(static_cast<uint16_t>(i));
    EXPECT_NEAR(value, expected, 4.5e-7);
    EXPECT_GT(value, last) << i;
    last = value;
  }
}

// The value between black and white is the linear mean, not the decoded mean of stored values
// (0.214).
TEST(Texture, DecodesBeforeFiltering) {
  const Texture texture(make_u8(2, 1, 3, {0, 0, 0, 255, 255, 255}),
                        {TextureWrap::repeat, TextureWrap::repeat, TextureFilter::linear, TextureEncoding::srgb});
  EXPECT_FLOAT_EQ(texture.sample_rgb({0.5f, 0.5f}).x, 0.5f);
}

TEST(Texture, AlphaIsLinearEvenInSrgb) {
  const Texture texture(make_u8(1, 1, 4, {128, 128, 128, 128}),
                        {TextureWrap::repeat, TextureWrap::repeat, TextureFilter::linear, TextureEncoding::srgb});
  EXPECT_FLOAT_EQ(texture.sample({0.5f, 0.5f}).w, 128.0f / 255.0f);
  EXPECT_FLOAT_EQ(texture.sample_channel({0.5f, 0.5f}, 3), 128.0f / 255.0f);
  EXPECT_NEAR(texture.sample({0.5f, 0.5f}).x, 0.2158605f, 1e-6f);
}

TEST(Texture, OpaqueAlphaIsExactlyOne) {
  std::mt19937 random(13);
  std::uniform_real_distribution<float> coordinate(-2.0f, 2.0f);
  for (const PixelType type : kTypes) {
    for (int channels = 1; channels <= 4; ++channels) {
      auto image = make_noise(9, 6, channels, type);
      if (channels == 2 || channels == 4) { // all texels opaque
        const size_t size = bytes_per_channel(type);
        const float one = 1.0f;
        const Imath::half half_one(1.0f);
        const uint16_t all_bits = 0xffff;
        const void* from = type == PixelType::f32   ? static_cast<const void*>(&one)
                           : type == PixelType::f16 ? static_cast<const void*>(&half_one)
                                                    : &all_bits;
        for (size_t i = 0; i < 54; ++i) {
          std::memcpy(&image->pixels[(i * static_cast<size_t>(channels) + static_cast<size_t>(channels) - 1) * size],
                      from, size);
        }
      }
      for (const TextureEncoding encoding : {TextureEncoding::linear, TextureEncoding::srgb}) {
        const Texture texture(image,
                              {TextureWrap::repeat, TextureWrap::mirrored_repeat, TextureFilter::linear, encoding});
        EXPECT_FALSE(texture.has_alpha);
        for (int i = 0; i < 200; ++i) {
          const V2f uv{coordinate(random), coordinate(random)};
          ASSERT_EQ(texture.sample(uv).w, 1.0f);
          ASSERT_EQ(texture.sample_channel(uv, 3), 1.0f);
        }
      }
    }
  }
}

TEST(Texture, OneTransparentTexelIsFound) {
  for (const int channels : {2, 4}) {
    std::vector<int> values(static_cast<size_t>(5 * 5 * channels), 255);
    values.back() = 254;
    EXPECT_TRUE(Texture(make_u8(5, 5, channels, values), {}).has_alpha);
  }
}

} // namespace
} // namespace kindling
