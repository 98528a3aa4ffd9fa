// Samples of many points at once have the bits of single samples.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/warp.h"
#include "tests/base/same_bits.h"
#include "tests/light/light_soup.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <vector>

namespace kindling {
namespace {

using test::same_bits;

void expect_same(const LightSample& found, const LightSample& expected) {
  ASSERT_TRUE(same_bits(found.wi, expected.wi)) << found.wi << " and " << expected.wi;
  ASSERT_TRUE(same_bits(found.distance, expected.distance));
  ASSERT_TRUE(same_bits(found.radiance, expected.radiance)) << found.radiance << " and " << expected.radiance;
  ASSERT_TRUE(same_bits(found.pdf, expected.pdf));
  ASSERT_TRUE(same_bits(found.normal, expected.normal));
  ASSERT_TRUE(same_bits(found.kind_probability, expected.kind_probability));
  ASSERT_EQ(found.delta, expected.delta);
  ASSERT_EQ(found.kind, expected.kind);
  const bool numbered = found.kind != LightKind::environment;
  ASSERT_TRUE(!numbered || found.emitter == expected.emitter);
}

// Compares a million samples, in groups of all sizes up to two of the set's own. Half of them are
// at the point of the one before, with its normal or another.
void compare(const LightSet& lights, float extent) {
  test::Random random(8);
  size_t hits = 0, points = 0;
  for (size_t size = 1; points < 1'000'000; size = size % 64 + 1, points += size) {
    std::vector<LightQuery> queries(size);
    for (size_t i = 0; i < size; ++i) {
      LightQuery& query = queries[i];
      const bool same_point = i > 0 && random.next_u64() % 2 == 0;
      query.point = same_point ? queries[i - 1].point : test::random_point(random, extent);
      query.normal = random.next_u64() % 8 == 0 ? V3f(0.0f) : test::random_direction(random);
      if (same_point && random.next_u64() % 4 != 0) query.normal = queries[i - 1].normal;
      query.u = random.next_2d();
      query.digits = random.next_1d();
      query.time = random.next_1d();
    }
    LightSample earlier;
    earlier.wi = V3f(0.0f);
    std::vector<std::optional<LightSample>> samples(size, earlier);
    lights.sample(queries, samples);
    for (size_t i = 0; i < size; ++i) {
      const std::optional<LightSample> expected = lights.sample(queries[i]);
      ASSERT_EQ(samples[i].has_value(), expected.has_value()) << i << " of " << size;
      if (expected) expect_same(*samples[i], *expected);
      if (testing::Test::HasFatalFailure()) return;
      hits += expected ? 1 : 0;
    }
  }
  EXPECT_GT(hits, points / 10);
}

TEST(ManyLightSamples, EmissiveTrianglesEqualSingleSamples) {
  LightSetInput input = test::light_soup(1, 300, 0, 0, nullptr);
  input.emissions[2].clearcoat = 0.7f;
  compare(LightSet(input), 10.0f);
}

TEST(ManyLightSamples, ANearTriangleEqualsSingleSamples) {
  LightSetInput input;
  input.emissions = {{Rgb(3.0f), nullptr, true}};
  input.triangles.push_back({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0});
  compare(LightSet(input), 2.0f);
}

TEST(ManyLightSamples, AllKindsEqualSingleSamples) {
  LightSetInput input = test::light_soup(2, 40, 5, 5, nullptr);
  DirectionalLight sun;
  sun.direction = {0.0f, -1.0f, 0.0f};
  sun.irradiance = Rgb(3.0f);
  sun.angular_diameter_rad = 0.01f;
  input.directionals = {sun};
  input.moving = {{0, 1}, {1, 1}}; // the last two triangles
  for (size_t i = input.triangles.size() - 2; i < input.triangles.size(); ++i) {
    const EmissiveTriangle& t = input.triangles[i];
    input.later_corners.push_back({t.p0 + V3f(1.0f), t.p1 + V3f(1.0f), t.p2 + V3f(1.0f)});
  }
  input.environment = std::make_shared<Environment>(test::uneven_image(64, 32), 0.3f, 1.0f);
  compare(LightSet(input), 10.0f);
}

TEST(ManyLightSamples, EnvironmentsEqualSingleSamples) {
  LightSetInput input;
  for (const auto& [width, height] : {std::pair(128, 64), std::pair(1, 1), std::pair(7, 3), std::pair(2, 9)}) {
    const auto image =
        width > 8
            ? test::uneven_image(width, height)
            : test::float_image(width, height, [](int x, int y) { return Rgb(static_cast<float>(1 + x + 3 * y)); });
    input.environment = std::make_shared<Environment>(image, 1.0f, 2.0f);
    compare(LightSet(input), 1.0f);
  }
  input.environment = std::make_shared<Environment>(Rgb(0.5f));
  compare(LightSet(input), 1.0f);
}

TEST(ManyLocations, EqualSingleOnes) {
  test::Random random(9);
  for (const float rotation : {0.0f, 1.3f, -3.0f}) {
    const Environment image(test::uneven_image(37, 19), rotation, 1.0f), uniform(Rgb(0.5f));
    for (size_t count = 0; count <= 33; ++count) {
      std::vector<V3f> directions{{0, 1, 0}, {0, -1, 0}, {-1, 0, 0}, {-1, 0, -0.0f}, {1, 0, 0}, {0, 0, -1}, {0, 0, 0}};
      while (directions.size() < count) directions.push_back(sample_uniform_sphere(random.next_2d()));
      directions.resize(count);
      for (const Environment* const environment : {&image, &uniform}) {
        std::vector<EnvironmentView::Location> found(count, {0.5f, 0.5f, 0.5f});
        std::vector<EnvironmentView::Location*> locations;
        for (EnvironmentView::Location& location : found) locations.push_back(&location);
        environment->locate(directions, locations);
        for (size_t i = 0; i < count; ++i) {
          const EnvironmentView::Location expected = environment->locate(directions[i]);
          ASSERT_TRUE(same_bits(V3f(found[i].u, found[i].v, found[i].sin_theta),
                                V3f(expected.u, expected.v, expected.sin_theta)))
              << directions[i];
        }
      }
    }
  }
}

} // namespace
} // namespace kindling
