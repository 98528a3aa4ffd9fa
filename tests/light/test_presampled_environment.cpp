// Tests of PresampledEnvironment: its entries, their density and cells, and light samples from it.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/presampled_environment.h"
#include "tests/base/same_bits.h"
#include "tests/light/light_fixtures.h"
#include "tests/sampling/chi_square.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace kindling {
namespace {

using test::Random;
using test::same_bits;
using Entry = PresampledEnvironmentView::Entry;
constexpr uint32_t kSide = PresampledEnvironmentView::kSide;

// Smooth enough for the rounding of a direction, 4e-7 turns, to change little: 64 texels around,
// neighbors at most three times as bright.
std::shared_ptr<const Environment> smooth_sky() {
  return std::make_shared<Environment>(test::float_image(64, 32,
                                                         [](int x, int y) {
                                                           const float wave = std::sin(0.6f * static_cast<float>(x)) +
                                                                              std::cos(0.5f * static_cast<float>(y));
                                                           return Rgb(1.0f, 0.7f, 0.4f) * std::exp(wave);
                                                         }),
                                       0.7f, 2.0f);
}

TEST(PresampledEnvironment, EntriesHaveRadianceAndDensityOfTheirDirections) {
  const auto sky = smooth_sky();
  const PresampledEnvironment table(*sky, 5);
  ASSERT_EQ(table.entries.size(), size_t{kSide} * kSide);
  EXPECT_EQ(table.memory_bytes(), table.entries.size() * 32);
  for (const Entry& entry : table.entries) {
    ASSERT_NEAR(entry.wi.length2(), 1.0f, 1e-5f);
    if (std::abs(entry.wi.y) > 0.999f) continue; // the azimuth is uncertain there
    const EnvironmentEval expected = sky->eval(entry.wi);
    // 64 texels times 4e-7 turns over the sine times a threefold change from texel to texel.
    constexpr float kRounding = 64 * 4e-7f / 0.04f * 3;
    ASSERT_NEAR(entry.pdf, expected.pdf, kRounding * expected.pdf);
    ASSERT_NEAR(entry.radiance.y, expected.radiance.y, kRounding * expected.radiance.y);
  }
}

// Rows of the table are ranges of the first of the two inversions, so they are ranges of rows of
// the image.
TEST(PresampledEnvironment, EntriesLieInTheirCells) {
  const auto sky = smooth_sky();
  const PresampledEnvironment table(*sky, 6);
  for (uint32_t row = 0; row < kSide; ++row) {
    const auto image_row = [&](uint32_t of) {
      return sky->distribution.rows.find(std::min(static_cast<float>(of) / kSide, kOneMinusEpsilon));
    };
    for (uint32_t column = 0; column < kSide; ++column) {
      const float row_in_image = sky->locate(table.entries[size_t{row} * kSide + column].wi).v * 32.0f + 0.5f;
      ASSERT_GE(row_in_image, static_cast<float>(image_row(row)) - 1e-4f);
      ASSERT_LE(row_in_image, static_cast<float>(image_row(row + 1) + 1) + 1e-4f);
    }
  }
}

TEST(PresampledEnvironment, EveryDrawHasAnEntry) {
  EXPECT_EQ(PresampledEnvironmentView::entry_of({0.0f, 0.0f}), 0U);
  EXPECT_EQ(PresampledEnvironmentView::entry_of({kOneMinusEpsilon, 0.0f}), kSide - 1);
  EXPECT_EQ(PresampledEnvironmentView::entry_of({0.0f, 1.5f / kSide}), kSide);
  EXPECT_EQ(PresampledEnvironmentView::entry_of({1.0f, 1.0f}), kSide * kSide - 1);
}

// Random entries of many tables. One table alone has as many directions as entries.
TEST(PresampledEnvironment, DirectionsHaveTheDensityOfTheEnvironment) {
  const auto sky = smooth_sky();
  std::vector<PresampledEnvironment> tables;
  for (uint32_t seed = 0; seed < 64; ++seed) tables.emplace_back(*sky, seed);
  const test::ChiSquareResult result = test::chi_square_sphere(
      [&](Random& random) -> std::optional<V3f> {
        const PresampledEnvironment& table = tables[random.next_u64() % tables.size()];
        return table.entries[PresampledEnvironmentView::entry_of(random.next_2d())].wi;
      },
      [&](const V3f& w) { return sky->pdf(w); }, {.seed = 3});
  EXPECT_GT(result.p_value, 1e-4) << result.summary;
  EXPECT_NEAR(result.integral, 1.0, 0.01);
}

// Also where one texel has most of the light, and others have none.
TEST(PresampledEnvironment, EntriesSumToTheLightOfTheEnvironment) {
  const Environment uneven(test::uneven_image(64, 32), 0.7f, 1.0f);
  test::Estimate light;
  for (uint32_t seed = 0; seed < 24; ++seed) {
    const PresampledEnvironment table(uneven, seed);
    double sum = 0.0;
    for (const Entry& entry : table.entries) sum += static_cast<double>(entry.radiance.x / entry.pdf);
    light.add(sum / static_cast<double>(table.entries.size()));
  }
  const double expected = static_cast<double>(uneven.total_radiance.x);
  EXPECT_NEAR(light.mean(), expected, 4.0 * light.standard_error() + 1e-5 * expected); // rounding of single precision
  EXPECT_LT(light.standard_error(), 2e-3 * expected);
}

TEST(PresampledEnvironment, SeedsGiveOtherTablesAndOneSeedTheSame) {
  const auto sky = smooth_sky();
  const PresampledEnvironment first(*sky, 1), again(*sky, 1), other(*sky, 2);
  size_t different = 0;
  for (size_t i = 0; i < first.entries.size(); ++i) {
    ASSERT_TRUE(same_bits(first.entries[i].wi, again.entries[i].wi));
    ASSERT_TRUE(same_bits(first.entries[i].pdf, again.entries[i].pdf));
    different += same_bits(first.entries[i].wi, other.entries[i].wi) ? 0 : 1;
  }
  EXPECT_EQ(different, first.entries.size());
}

// Some queries of a group read the table, others draw, others choose the lamp.
TEST(PresampledEnvironment, ManyLightSamplesEqualSingleOnes) {
  const auto sky = smooth_sky();
  LightSetInput input;
  input.emissions.push_back({.factor = Rgb(20.0f)});
  test::add_rectangle(input, V3f(-1, 3, -1), V3f(2, 0, 0), V3f(0, 0, 2), 0);
  input.environment = sky;
  const LightSet lights(std::move(input));
  const PresampledEnvironment table(*sky, 7);
  Random random(4);
  std::vector<LightQuery> queries(999);
  for (LightQuery& query : queries) {
    query.normal = V3f(0, 1, 0);
    query.point = V3f(4.0f * random.next_1d() - 2.0f, 0, 0);
    query.u = random.next_2d();
    query.digits = random.next_1d();
    if (random.next_1d() < 0.5f) query.presampled = &table;
  }
  std::vector<std::optional<LightSample>> samples(queries.size());
  lights.sample(queries, samples);
  int from_table = 0, drawn = 0, of_lamp = 0;
  for (size_t i = 0; i < queries.size(); ++i) {
    const std::optional<LightSample> expected = lights.sample(queries[i]);
    ASSERT_EQ(samples[i].has_value(), expected.has_value());
    if (!expected) continue;
    ASSERT_EQ(samples[i]->kind, expected->kind);
    ASSERT_TRUE(same_bits(samples[i]->wi, expected->wi));
    ASSERT_TRUE(same_bits(samples[i]->pdf, expected->pdf));
    ASSERT_TRUE(same_bits(samples[i]->radiance, expected->radiance));
    ASSERT_EQ(samples[i]->distance, expected->distance);
    ++(expected->kind != LightKind::environment ? of_lamp : queries[i].presampled != nullptr ? from_table : drawn);
    if (queries[i].presampled == nullptr || expected->kind != LightKind::environment) continue;
    const bool listed = std::any_of(table.entries.begin(), table.entries.end(),
                                    [&](const Entry& entry) { return same_bits(entry.wi, expected->wi); });
    ASSERT_TRUE(listed);
  }
  EXPECT_GT(from_table, 50);
  EXPECT_GT(drawn, 50);
  EXPECT_GT(of_lamp, 50);
}

// Where there is no other light, groups that only read tables have steps of their own.
TEST(PresampledEnvironment, ManySamplesOfTheSkyAloneEqualSingleOnes) {
  const auto sky = smooth_sky();
  LightSetInput input;
  input.environment = sky;
  const LightSet lights(std::move(input));
  const PresampledEnvironment table(*sky, 7);
  Random random(5);
  for (const float with_table : {1.0f, 0.9f}) {
    std::vector<LightQuery> queries(999);
    for (LightQuery& query : queries) {
      query.point = V3f(0.0f);
      query.normal = V3f(0, 1, 0);
      query.u = random.next_2d();
      query.digits = random.next_1d();
      if (random.next_1d() < with_table) query.presampled = &table;
    }
    queries.back().u = V2f(1.0f, 0.5f); // the largest value that the draw of a kind may leave
    std::vector<std::optional<LightSample>> samples(queries.size());
    lights.sample(queries, samples);
    for (size_t i = 0; i < queries.size(); ++i) {
      const std::optional<LightSample> expected = lights.sample(queries[i]);
      ASSERT_TRUE(samples[i] && expected);
      ASSERT_EQ(samples[i]->kind, LightKind::environment);
      ASSERT_EQ(samples[i]->distance, kInfinity);
      ASSERT_TRUE(same_bits(samples[i]->wi, expected->wi));
      ASSERT_TRUE(same_bits(samples[i]->pdf, expected->pdf));
      ASSERT_TRUE(same_bits(samples[i]->kind_probability, expected->kind_probability));
      ASSERT_TRUE(same_bits(samples[i]->radiance, expected->radiance));
    }
  }
}

} // namespace
} // namespace kindling
