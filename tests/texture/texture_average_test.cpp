// Tests of texture averages over triangles against quadrature, and with small bright features.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/texture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace kindling {
namespace {

std::shared_ptr<Image> make_small_u8(int width, int height, int channels, const std::vector<int>& values) {
  auto image = std::make_shared<Image>(Image{width, height, channels, PixelType::u8, {}});
  for (const int value : values) image->pixels.push_back(static_cast<std::byte>(value));
  return image;
}

std::shared_ptr<Image> make_u8_noise(int width, int height, int channels, uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<int> values(static_cast<size_t>(width * height * channels));
  for (int& value : values) value = static_cast<int>(random() & 255);
  return make_small_u8(width, height, channels, values);
}

TEST(TextureAverage, ConstantIsExact) {
  const Texture texture(make_small_u8(4, 4, 1, std::vector<int>(16, 51)), {});
  EXPECT_FLOAT_EQ(texture.average_rgb({0.0f, 0.0f}, {3.0f, 0.0f}, {0.0f, 3.0f}).y, 0.2f);
  // A triangle without area gives the mean of its points.
  EXPECT_FLOAT_EQ(texture.average_rgb({0.2f, 0.2f}, {0.2f, 0.2f}, {0.2f, 0.2f}).x, 0.2f);
}

// The reference is a fine grid. The point set has at least two points for each texel of white noise
// (standard deviation 0.29, about 0.19 after bilinear filtering), so the error over n texels is
// about 0.19 / sqrt(2 n); the tolerance is five times that.
TEST(TextureAverage, MatchesFineGrid) {
  const auto image = make_u8_noise(64, 64, 3, 5);
  const Texture texture(image, {});
  const V2f corners[][3] = {
      {{0, 0}, {1, 0}, {0, 1}}, {{0.1f, 0.2f}, {0.9f, 0.3f}, {0.5f, 0.8f}}, {{2, 2}, {0, 1.9f}, {0.3f, 0}}};
  for (const auto& c : corners) {
    constexpr int kGrid = 700;
    Imath::V3d sum(0.0);
    int count = 0;
    for (int i = 0; i < kGrid; ++i) {
      for (int k = 0; k < kGrid - i; ++k, ++count) {
        const float a = (static_cast<float>(i) + 1.0f / 3.0f) / kGrid,
                    b = (static_cast<float>(k) + 1.0f / 3.0f) / kGrid;
        sum += Imath::V3d(texture.sample_rgb(c[0] + (c[1] - c[0]) * a + (c[2] - c[0]) * b));
      }
    }
    const V2f e1 = c[1] - c[0], e2 = c[2] - c[0];
    const double texels = 0.5 * std::abs(e1.x * e2.y - e1.y * e2.x) * 64 * 64;
    const Rgb mean = texture.average_rgb(c[0], c[1], c[2]);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(mean[k], sum[k] / count, 5 * 0.19 / std::sqrt(2 * texels));
  }
}

// A bright texel of a dark 512 x 512 image is neither missed nor overestimated.
TEST(TextureAverage, FindsSmallLamp) {
  std::vector<int> values(512 * 512, 0);
  for (int y = 300; y < 308; ++y) {
    for (int x = 100; x < 108; ++x) values[static_cast<size_t>(y * 512 + x)] = 255;
  }
  const Texture texture(make_small_u8(512, 512, 1, values), {});
  const double expected = 64.0 / (512.0 * 512.0);
  const double both =
      0.5 * (texture.average_rgb({0, 0}, {1, 0}, {1, 1}).x + texture.average_rgb({0, 0}, {1, 1}, {0, 1}).x);
  EXPECT_NEAR(both, expected,
              0.35 * expected); // 16 points on 64 texels, so 1/4 for each texel: an upper bound from Poisson statistics
}

TEST(TextureAverage, IsDeterministic) {
  const Texture texture(make_u8_noise(32, 32, 3, 6), {});
  EXPECT_EQ(texture.average_rgb({0, 0}, {1, 0.2f}, {0.3f, 1}), texture.average_rgb({0, 0}, {1, 0.2f}, {0.3f, 1}));
}

} // namespace
} // namespace kindling
