// Tests of the Environment: directions, rotation, poles, texel formats and its density.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/environment.h"
#include "tests/light/light_fixtures.h"

#include <gtest/gtest.h>

#include <numbers>

namespace kindling {
namespace {

using test::float_image;
using test::rotate_y;

V3f uniform_direction(test::Random& random) {
  const double z = 2.0 * static_cast<double>(random.next_1d()) - 1.0;
  const double phi = 2.0 * std::numbers::pi * static_cast<double>(random.next_1d());
  const double r = std::sqrt(1.0 - z * z);
  return {static_cast<float>(r * std::cos(phi)), static_cast<float>(z), static_cast<float>(r * std::sin(phi))};
}

// The mapping of the specification in double precision with textbook interpolation.
Rgb reference_radiance(const Image& image, const V3f& d) {
  const double u = 0.5 + std::atan2(static_cast<double>(d.z), static_cast<double>(d.x)) / (2.0 * std::numbers::pi);
  const double v = std::acos(std::clamp(static_cast<double>(d.y), -1.0, 1.0)) / std::numbers::pi;
  const double x = u * image.width - 0.5;
  const double y = v * image.height - 0.5;
  const double fx = x - std::floor(x);
  const double fy = y - std::floor(y);
  const auto texel = [&](int tx, int ty) {
    tx = ((tx % image.width) + image.width) % image.width;
    ty = std::clamp(ty, 0, image.height - 1);
    float c[3];
    const size_t pixel = static_cast<size_t>(ty) * static_cast<size_t>(image.width) + static_cast<size_t>(tx);
    std::memcpy(c, image.pixels.data() + pixel * sizeof(c), sizeof(c));
    return V3d(static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2]));
  };
  const int x0 = static_cast<int>(std::floor(x));
  const int y0 = static_cast<int>(std::floor(y));
  const V3d c = (texel(x0, y0) * (1 - fx) + texel(x0 + 1, y0) * fx) * (1 - fy) +
                (texel(x0, y0 + 1) * (1 - fx) + texel(x0 + 1, y0 + 1) * fx) * fy;
  return Rgb(c);
}

TEST(Equirect, AnglesAreAccurate) {
  test::Random random(1);
  double worst_atan = 0.0;
  double worst_acos = 0.0;
  for (int i = 0; i < 2'000'000; ++i) {
    const V3f d = uniform_direction(random);
    const double turns = std::atan2(static_cast<double>(d.z), static_cast<double>(d.x)) / (2.0 * std::numbers::pi);
    worst_atan = std::max(worst_atan, std::fabs(static_cast<double>(atan2_turns(d.z, d.x)) - turns));
    const float c = 2.0f * random.next_1d() - 1.0f;
    worst_acos = std::max(worst_acos, std::fabs(static_cast<double>(acos_half_turns(c)) -
                                                std::acos(static_cast<double>(c)) / std::numbers::pi));
  }
  // Bounds that the header states; in radians 1.3e-6 and 6e-7.
  EXPECT_LT(worst_atan, 2e-7);
  EXPECT_LT(worst_acos, 2e-7);
}

TEST(Equirect, HandlesSpecialValues) {
  EXPECT_EQ(atan2_turns(0.0f, 1.0f), 0.0f);
  EXPECT_EQ(atan2_turns(1.0f, 0.0f), 0.25f);
  EXPECT_EQ(atan2_turns(-1.0f, 0.0f), -0.25f);
  EXPECT_EQ(atan2_turns(0.0f, -1.0f), 0.5f);
  EXPECT_EQ(atan2_turns(0.0f, 0.0f), 0.0f);
  EXPECT_EQ(atan2_turns(1e-45f, 0.0f), 0.25f);
  EXPECT_NEAR(atan2_turns(1.0f, 1.0f), 0.125f, 1e-7f);
  EXPECT_EQ(acos_half_turns(1.0f), 0.0f);
  EXPECT_EQ(acos_half_turns(-1.0f), 1.0f);
  EXPECT_EQ(acos_half_turns(1.0000002f), 0.0f);
  EXPECT_EQ(acos_half_turns(-1.0000002f), 1.0f);
  EXPECT_NEAR(acos_half_turns(0.0f), 0.5f, 1e-7f);
}

// An 8 x 4 image whose texels hold their own coordinates.
std::shared_ptr<const Image> coordinate_image() {
  return float_image(8, 4, [](int x, int y) { return Rgb(static_cast<float>(x), static_cast<float>(y), 1.0f); });
}

TEST(Environment, DirectionsMapAsDocumented) {
  const Environment environment(coordinate_image(), 0.0f, 1.0f);
  // At u = k / 8 the texels k - 1 and k meet; v = 0.5 is between rows 1 and 2.
  EXPECT_NEAR(environment.radiance({1, 0, 0}).x, 3.5f, 1e-5f);  // u = 0.5
  EXPECT_NEAR(environment.radiance({0, 0, 1}).x, 5.5f, 1e-5f);  // u = 0.75
  EXPECT_NEAR(environment.radiance({0, 0, -1}).x, 1.5f, 1e-5f); // u = 0.25
  EXPECT_NEAR(environment.radiance({-1, 0, 0}).x, 3.5f, 1e-5f); // the seam: half of texel 7, half of texel 0
  EXPECT_NEAR(environment.radiance({1, 0, 0}).y, 1.5f, 1e-5f);
  // Poles: v = 0 is the top row, clamped.
  EXPECT_EQ(environment.radiance({0, 1, 0}).y, 0.0f);
  EXPECT_EQ(environment.radiance({0, -1, 0}).y, 3.0f);
}

TEST(Environment, MatchesReferenceInterpolation) {
  const auto image = test::uneven_image(37, 19); // odd sizes avoid round numbers
  const Environment environment(image, 0.0f, 1.0f);
  test::Random random(2);
  for (int i = 0; i < 100'000; ++i) {
    const V3f d = uniform_direction(random);
    const Rgb expected = reference_radiance(*image, d);
    const Rgb found = environment.radiance(d);
    // Stored as halves (2^-11 relative), and u is off by 2e-7: 37 texels * 2e-7 * 4000 is 0.03 near
    // the bright one.
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(found[c], expected[c], 5e-4f * expected[c] + 0.06f) << d;
  }
}

TEST(Environment, HalfImagesAreExact) {
  test::Random random(3);
  const auto image = float_image(16, 8, [&](int, int) {
    return Rgb{Imath::half(random.next_1d()), Imath::half(100.0f * random.next_1d()),
               Imath::half(6e4f * random.next_1d())};
  });
  const Environment environment(image, 0.0f, 1.0f);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 16; ++x) {
      const double phi = 2.0 * std::numbers::pi * ((x + 0.5) / 16.0 - 0.5);
      const double theta = std::numbers::pi * (y + 0.5) / 8.0;
      const V3f d(static_cast<float>(std::sin(theta) * std::cos(phi)), static_cast<float>(std::cos(theta)),
                  static_cast<float>(std::sin(theta) * std::sin(phi)));
      const Rgb expected = reference_radiance(*image, d);
      const Rgb found = environment.radiance(d);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], 1e-5f * 6e4f * (c == 2 ? 1.0f : 1e-2f));
    }
  }
}

TEST(Environment, RotationIsCounterclockwiseFromAbove) {
  const auto image = test::uneven_image(32, 16);
  const Environment still(image, 0.0f, 1.0f);
  for (const float r : {0.5f, -2.0f, 7.0f, kPi}) {
    const Environment turned(image, r, 1.0f);
    test::Random random(4);
    for (int i = 0; i < 1000; ++i) {
      const V3f d = uniform_direction(random);
      const Rgb expected = still.radiance(d);
      EXPECT_NEAR(turned.radiance(rotate_y(d, r)).x, expected.x, 1e-3f * expected.x + 0.1f) << r << " " << d;
    }
  }
  // A quarter turn moves +X to -Z.
  const auto spot = float_image(64, 32, [](int x, int) { return x == 31 || x == 32 ? Rgb(1.0f) : Rgb(0.0f); });
  EXPECT_NEAR(Environment(spot, 0.0f, 1.0f).radiance({1, 0, 0}).x, 1.0f, 1e-5f);
  EXPECT_NEAR(Environment(spot, kPi / 2, 1.0f).radiance({0, 0, -1}).x, 1.0f, 1e-4f);
  EXPECT_EQ(Environment(spot, kPi / 2, 1.0f).radiance({0, 0, 1}).x, 0.0f);
}

TEST(Environment, IntensityScalesRadianceButNotDensity) {
  const auto image = test::uneven_image(32, 16);
  const Environment one(image, 0.3f, 1.0f);
  const Environment three(image, 0.3f, 3.0f);
  test::Random random(5);
  for (int i = 0; i < 1000; ++i) {
    const V3f d = uniform_direction(random);
    EXPECT_FLOAT_EQ(three.radiance(d).x, 3.0f * one.radiance(d).x);
    EXPECT_EQ(three.pdf(d), one.pdf(d));
  }
  EXPECT_FLOAT_EQ(three.total_radiance.y, 3.0f * one.total_radiance.y);
}

TEST(Environment, BlackEnvironmentHasNoSamples) {
  const auto black = float_image(8, 4, [](int, int) { return Rgb(0.0f); });
  for (const Environment& environment :
       {Environment(black, 0.0f, 1.0f), Environment(Rgb(0.0f)), Environment(nullptr, 0.0f, 1.0f),
        Environment(coordinate_image(), 0.0f, 0.0f), Environment(std::make_shared<Image>(), 0.0f, 1.0f)}) {
    EXPECT_TRUE(environment.is_black());
    EXPECT_EQ(environment.radiance({0, 1, 0}), Rgb(0.0f));
    EXPECT_EQ(environment.pdf({0, 1, 0}), 0.0f);
    const LightSample sample = environment.sample({0.3f, 0.7f});
    EXPECT_EQ(sample.pdf, 0.0f);
    EXPECT_EQ(sample.radiance, Rgb(0.0f));
    EXPECT_EQ(environment.total_radiance, Rgb(0.0f));
  }
}

TEST(Environment, UniformColorHasConstantDensity) {
  const Environment environment(Rgb(1.0f, 2.0f, 3.0f));
  EXPECT_EQ(environment.radiance({0.6f, 0.8f, 0.0f}), Rgb(1.0f, 2.0f, 3.0f));
  EXPECT_FLOAT_EQ(environment.pdf({0.6f, 0.8f, 0.0f}), 1.0f / (4.0f * kPi));
  EXPECT_FLOAT_EQ(environment.total_radiance.y, 8.0f * kPi);
  const LightSample sample = environment.sample({0.3f, 0.7f});
  EXPECT_NEAR(sample.wi.length(), 1.0f, 1e-6f);
  EXPECT_EQ(sample.distance, kInfinity);
  EXPECT_EQ(sample.radiance, Rgb(1.0f, 2.0f, 3.0f));
}

TEST(Environment, InvalidTexelsReadAsZero) {
  const float bad[] = {-1.0f, kInfinity, -kInfinity, std::numeric_limits<float>::quiet_NaN()};
  const auto image = float_image(8, 4, [&](int x, int y) { return y == 1 ? Rgb(bad[x % 4]) : Rgb(2.0f); });
  const Environment environment(image, 0.0f, 1.0f);
  test::Random random(6);
  for (int i = 0; i < 10'000; ++i) {
    const Rgb c = environment.radiance(uniform_direction(random));
    ASSERT_TRUE(c.x >= 0.0f && c.x <= 2.0f) << c;
    const LightSample sample = environment.sample(random.next_2d());
    ASSERT_TRUE(sample.pdf > 0.0f && std::isfinite(sample.pdf));
  }
  // A NaN direction must not read out of bounds.
  (void)environment.eval(V3f(std::numeric_limits<float>::quiet_NaN()));
}

TEST(Environment, ReadsEveryPixelType) {
  Image u8{2, 1, 1, PixelType::u8, {std::byte{255}, std::byte{255}}};
  EXPECT_NEAR(Environment(std::make_shared<Image>(u8), 0.0f, 1.0f).radiance({1, 0, 0}).y, 1.0f, 1e-6f);
  Image mid{1, 1, 4, PixelType::u8, {std::byte{188}, std::byte{0}, std::byte{255}, std::byte{7}}};
  const Rgb c = Environment(std::make_shared<Image>(mid), 0.0f, 1.0f).radiance({1, 0, 0});
  EXPECT_NEAR(c.x, 0.5029f, 2e-4f); // sRGB 188 is 0.5029 linear
  EXPECT_EQ(c.y, 0.0f);
  EXPECT_NEAR(c.z, 1.0f, 1e-6f);
  Image u16{1, 1, 2, PixelType::u16, {std::byte{0xff}, std::byte{0xff}, std::byte{0}, std::byte{0}}};
  EXPECT_NEAR(Environment(std::make_shared<Image>(u16), 0.0f, 1.0f).radiance({0, 0, 1}).z, 1.0f, 1e-6f);
  const uint16_t two_and_a_half = Imath::half(2.5f).bits();
  Image f16{1, 1, 1, PixelType::f16, {std::byte(two_and_a_half & 255), std::byte(two_and_a_half >> 8)}};
  EXPECT_EQ(Environment(std::make_shared<Image>(f16), 0.0f, 1.0f).radiance({0, 0, 1}).z, 2.5f);
}

TEST(Environment, KeepsExtremeDynamicRange) {
  // A sun of 1e9 over a sky of 1 exceeds the range of a half.
  const auto image = float_image(64, 32, [](int x, int y) { return x == 10 && y == 5 ? Rgb(1e9f) : Rgb(1.0f); });
  const Environment environment(image, 0.0f, 1.0f);
  EXPECT_NEAR(environment.radiance({0, -1, 0}).x, 1.0f, 2e-3f);
  for (const float peak : {1e-38f, 1e-20f, 3e38f}) {
    const auto flat = float_image(4, 2, [&](int, int) { return Rgb(peak); });
    EXPECT_NEAR(Environment(flat, 0.0f, 1.0f).radiance({0, 0, 1}).x / peak, 1.0f, 5e-4f);
  }
}

TEST(Environment, MemoryIsAsDocumented) {
  const auto bytes = [](int width) {
    return static_cast<double>(Environment(test::uneven_image(width, width / 2), 0.0f, 1.0f).memory_bytes());
  };
  // 8 bytes for each texel of the levels, which together have a third more than the finest.
  EXPECT_LT(bytes(512), 13.5 * 512 * 256 + 1.4 * 8 * 256 * 128);
  EXPECT_LT(bytes(2048), 13.5 * 2048 * 1024 + 1.4 * 8 * 512 * 256);
}

// The uniform part of the sky is left to BSDF sampling, the sun is not; a uniform color is sampled
// uniformly.
TEST(Environment, DensityIsMisCompensated) {
  const auto sky = [](float sun) {
    return Environment(float_image(64, 32, [&](int x, int y) { return Rgb(x == 20 && y == 8 ? sun : 1.0f); }), 0.0f,
                       1.0f);
  };
  const Environment even = sky(1.0f);
  EXPECT_NEAR(even.sampled_fraction(), 0.3f, 2e-3f);
  EXPECT_NEAR(even.pdf(V3f(0.6f, 0.48f, 0.64f)), 0.25f * kInvPi,
              2.5e-3f * kInvPi); // sin(theta) within a row is not resolved
  const Environment sunny = sky(1e5f);
  EXPECT_GT(sunny.sampled_fraction(), 0.9f);
  EXPECT_LT(sunny.sampled_fraction(), 1.0f);
  EXPECT_GT(sunny.pdf(V3f(0.0f, -1.0f, 0.0f)), 0.0f); // far from the sun, but still possible
  EXPECT_EQ(Environment(Rgb(2.0f)).sampled_fraction(), 1.0f);
}

TEST(Environment, DensityIsPositiveWhereverThereIsLight) {
  const Environment environment(test::uneven_image(37, 19), 1.0f, 1.0f);
  test::Random random(8);
  for (int i = 0; i < 200'000; ++i) {
    const V3f direction = uniform_direction(random);
    const EnvironmentEval eval = environment.eval(direction);
    ASSERT_TRUE(eval.pdf > 0.0f || is_black(eval.radiance));
    ASSERT_EQ(environment.radiance(direction), eval.radiance);
  }
}

TEST(Environment, SamplePdfMatchesLookup) {
  for (const int width : {37, 512}) {
    const Environment environment(test::uneven_image(width, width / 2), 2.0f, 1.0f);
    test::Random random(9);
    int different = 0;
    constexpr int kSamples = 100'000;
    for (int i = 0; i < kSamples; ++i) {
      const LightSample sample = environment.sample(random.next_2d());
      ASSERT_NEAR(sample.wi.length2(), 1.0f, 1e-5f);
      ASSERT_GT(sample.pdf, 0.0f);
      const EnvironmentEval eval = environment.eval(sample.wi);
      if (std::fabs(eval.pdf - sample.pdf) > 5e-4f * sample.pdf) ++different;
      const float tolerance = 2e-3f * max_component(sample.radiance) + 4000.0f * 4e-7f * static_cast<float>(width);
      ASSERT_NEAR(eval.radiance.x, sample.radiance.x, tolerance);
    }
    // Only directions within about 4e-7 turns of a texel's border may read the neighbor; half of
    // the samples are in one texel.
    EXPECT_LT(different, kSamples * 4e-7 * width * 20 + 10);
  }
}

} // namespace
} // namespace kindling
