// The model by which pilots choose light samples, reflection samples and pixels that share paths.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/sample_model.h"

#include <gtest/gtest.h>

namespace kindling::test {
namespace {

constexpr OpenCounts kAllOpen{true, true, true};

TEST(SampleModel, PartsOfTheNoiseFallWithTheirNumbers) {
  const SampleModel model{.of_lights = 0.5, .of_reflections = 0.2, .of_sharing = 0.16};
  EXPECT_DOUBLE_EQ(model.error({}), 1.0);
  EXPECT_DOUBLE_EQ(model.error({5, 0, 1}), 1.0 - 0.5 * 0.8);
  EXPECT_DOUBLE_EQ(model.error({1, 4, 1}), 1.0 - 0.2 * 0.8);
  EXPECT_DOUBLE_EQ(model.error({1, 0, 4}), 1.0 - 0.16 * 0.75);
  EXPECT_DOUBLE_EQ(model.error({5, 4, 4}), 1.0 - 0.4 - 0.16 - 0.12);
}

TEST(SampleModel, NumbersThatWereGivenAreTheUnit) {
  const SampleModel model{.first = {4, 1, 1}, .of_sharing = 0.8, .light_cost = 0.1, .reflection_cost = 0.2};
  EXPECT_DOUBLE_EQ(model.product(model.first), 1.0);
  const SampleCounts best = best_counts(model, {.pixels = true});
  EXPECT_EQ(best.lights, 4);
  EXPECT_EQ(best.reflections, 1);
  EXPECT_EQ(best.pixels, 8);
}

TEST(SampleModel, CostRisesByTheSameForEachOneMore) {
  const SampleModel model{.light_cost = 0.1, .reflection_cost = 0.2, .sharing_cost = 0.05, .pixel_cost = 0.01};
  EXPECT_DOUBLE_EQ(model.cost({3, 0, 1}), 1.2);
  EXPECT_DOUBLE_EQ(model.cost({1, 2, 1}), 1.4);
  EXPECT_DOUBLE_EQ(model.cost({1, 0, 8}), 1.12);
  EXPECT_DOUBLE_EQ(model.cost({3, 2, 8}), 1.72);
}

// The square root of b / (a d) is the best number where the noise is a + b / n and the cost 1 - d +
// d n.
TEST(SampleModel, BestNumberOfLightSamplesIsThatOfTheFormula) {
  const SampleModel model{.of_lights = 0.75, .light_cost = 0.1};
  EXPECT_EQ(best_counts(model, {.lights = true}).lights, 5); // sqrt(0.75 * 0.9 / (0.25 * 0.1)) = 5.2
}

TEST(SampleModel, SmallGainsChangeNothing) {
  const SampleCounts best =
      best_counts({.of_lights = 0.02, .of_reflections = 0.01, .of_sharing = 0.02, .pixel_cost = 0.001}, kAllOpen);
  EXPECT_EQ(best.lights, 1);
  EXPECT_EQ(best.reflections, 0);
  EXPECT_EQ(best.pixels, 1);
}

TEST(SampleModel, MoreLightSamplesThanWereMeasuredMustGainMore) {
  SampleModel model{.of_lights = 0.9, .light_cost = 0.001};
  EXPECT_EQ(best_counts(model, {.lights = true}).lights, kMaxChosenDirectSamples); // product .16 in place of .21
  model.of_lights = 0.5;                                                           // .56 in place of .53
  EXPECT_EQ(best_counts(model, {.lights = true}).lights, kMeasuredDirectSamples);
}

// Sharing takes a tenth of the noise away beside one light sample, and two fifths beside eight.
TEST(SampleModel, SharingPaysBesideLightSamples) {
  SampleModel model{.of_lights = 0.85, .of_sharing = 0.12, .light_cost = 0.02, .sharing_cost = 0.1};
  EXPECT_EQ(best_counts(model, {.pixels = true}).pixels, 1);
  const SampleCounts best = best_counts(model, {.lights = true, .pixels = true});
  EXPECT_EQ(best.pixels, 8);
  EXPECT_GT(best.lights, 4);
  model.sharing_cost = 1.5;
  EXPECT_EQ(best_counts(model, {.lights = true, .pixels = true}).pixels, 1);
}

} // namespace
} // namespace kindling::test
