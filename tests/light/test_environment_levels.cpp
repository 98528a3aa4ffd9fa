// Tests of the means of an Environment over wide areas: exact sums, continuity and small images.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/environment.h"
#include "tests/light/light_fixtures.h"

#include "renderer/sampling/warp.h"

#include <gtest/gtest.h>

#include <numbers>

namespace kindling {
namespace {

using test::float_image;
using test::uneven_image;

// The solid angle of row y of an image of `height` rows, over that of the sphere.
double share_of_row(int y, int height) {
  const auto cosine = [&](int edge) { return std::cos(std::numbers::pi * edge / height); };
  return 0.5 * (cosine(y) - cosine(y + 1));
}

Rgb at_center(const EnvironmentLevels& levels, int level, int x, int y) {
  const int width = levels.width >> level;
  return levels.at(level, (static_cast<float>(x) + 0.5f) / static_cast<float>(width),
                   (static_cast<float>(y) + 0.5f) / static_cast<float>(width / 2));
}

TEST(EnvironmentLevels, AreHalfAsWideUpToALimit) {
  const auto width_for = [](int width) {
    return Environment(float_image(width, width / 2, [](int, int) { return Rgb(1.0f); }), 0.0f, 1.0f).levels.width;
  };
  EXPECT_EQ(width_for(15), 0);
  EXPECT_EQ(width_for(16), 8);
  EXPECT_EQ(width_for(100), 32);
  EXPECT_EQ(width_for(1024), 512);
  EXPECT_EQ(width_for(2048), 512);
  EXPECT_EQ(Environment(Rgb(1.0f)).levels.count(), 0);
}

// The image is no multiple of the levels in size.
TEST(EnvironmentLevels, AverageTheirPartsOfTheImageBySolidAngle) {
  const auto image = uneven_image(150, 70);
  const Environment environment(image, 0.0f, 1.0f);
  const EnvironmentLevels& levels = environment.levels;
  ASSERT_EQ(levels.width, 64);
  ASSERT_EQ(levels.count(), 4);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 8; ++x) {
      V3d sum(0.0);
      double total = 0.0;
      // A texel of the coarsest level covers 75 quarters of columns and 35 halves of rows.
      for (int j = 0; j < 35; ++j)
        for (int i = 0; i < 75; ++i) {
          const int column = (x * 75 + i) / 4, row = (y * 35 + j) / 2;
          const double weight = share_of_row(y * 35 + j, 140);
          float c[3];
          std::memcpy(c,
                      image->pixels.data() + (static_cast<size_t>(row) * 150 + static_cast<size_t>(column)) * sizeof c,
                      sizeof c);
          sum += V3d(static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2])) * weight;
          total += weight;
        }
      const Rgb expected(sum / total), mean = at_center(levels, 3, x, y) * environment.scale;
      // Texels and their mean are halves: 2^-11 of each, or half a step of the smallest ones.
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(mean[c], expected[c], expected[c] * 0x1p-10f + environment.scale * 0x1p-24f) << x << ' ' << y;
    }
}

TEST(EnvironmentLevels, KeepTheTotal) {
  const Environment environment(uneven_image(300, 150), 0.0f, 1.0f);
  const EnvironmentLevels& levels = environment.levels;
  // Without interpolation, as levels are averaged.
  const auto total_of = [&](int width, const auto& read) {
    V3d total(0.0);
    for (int y = 0; y < width / 2; ++y)
      for (int x = 0; x < width; ++x) total += V3d(read(x, y)) * (share_of_row(y, width / 2) / width);
    return total;
  };
  const V3d all = total_of(300, [&](int x, int y) {
    const Fp16Texel& t = environment.texels[environment.texel_index(x, y)];
    return V3f(half_to_float(t.r), half_to_float(t.g), half_to_float(t.b));
  });
  for (int level = 0; level < levels.count(); ++level) {
    const V3d total = total_of(levels.width >> level, [&](int x, int y) { return at_center(levels, level, x, y); });
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(total[c], all[c], all[c] * 0x1p-10) << level;
  }
}

TEST(EnvironmentLevels, ChangeTheMeanSteadilyWithTheWidth) {
  const Environment environment(uneven_image(256, 128), 0.3f, 1.0f);
  test::Random random(3);
  for (int i = 0; i < 50; ++i) {
    const auto at = environment.locate(sample_uniform_sphere(random.next_2d()));
    Rgb before = environment.mean_radiance(at, 0.0f);
    EXPECT_EQ(before, environment.eval(at).radiance);
    // In steps of a hundredth of a level, past all of them.
    for (float width = 0x1p-9f; width < 1.0f; width *= 1.00695555f) {
      const Rgb mean = environment.mean_radiance(at, width);
      const float coarse = max_component(environment.mean_radiance(at, 2.1f * width));
      const float fine = max_component(environment.mean_radiance(at, width / 2.1f));
      EXPECT_LE(max_component(before - mean), 0.02f * (fine + coarse + max_component(mean)) + 1e-6f)
          << i << ' ' << width;
      before = mean;
    }
    EXPECT_EQ(before, environment.mean_radiance(at, 8.0f));
  }
}

TEST(EnvironmentLevels, AreUniformWhereTheImageIs) {
  const Environment environment(float_image(64, 32, [](int, int) { return Rgb(0.5f, 1.0f, 2.0f); }), 0.0f, 3.0f);
  const Environment small(float_image(8, 4, [](int x, int) { return Rgb(static_cast<float>(x)); }), 0.0f, 1.0f);
  test::Random random(4);
  for (const float width : {0.0f, 0.01f, 0.03f, 0.1f, 0.5f, 3.0f})
    for (int i = 0; i < 20; ++i) {
      const V3f direction = sample_uniform_sphere(random.next_2d());
      const Rgb mean = environment.mean_radiance(environment.locate(direction), width);
      EXPECT_LT((mean - Rgb(1.5f, 3.0f, 6.0f)).length(), 1e-5f);
      EXPECT_EQ(small.mean_radiance(small.locate(direction), width), small.radiance(direction));
    }
}

} // namespace
} // namespace kindling
