// The model by which pilots choose light samples, reflection samples and pixels that share paths.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/sample_model.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kindling::test {
namespace {

constexpr OpenCounts kAllOpen{true, true, true};

// Four samples have 2^-2.6 times the noise of one, and two have 2^-1.3 times. The model rounds
// these powers to floats.
TEST(SampleModel, PartsOfTheNoiseFallWithTheirNumbers) {
  constexpr double kRounding = 1e-7;
  const SampleModel model{.of_lights = 0.5, .of_reflections = 0.2, .of_sharing = 0.16};
  const double of_four = 1.0 - std::exp2(-2.6), of_two = 1.0 - std::exp2(-1.3);
  EXPECT_DOUBLE_EQ(model.error({}), 1.0);
  EXPECT_NEAR(model.error({4, 0, 1}), 1.0 - 0.5 * of_four, kRounding);
  EXPECT_NEAR(model.error({1, 1, 1}), 1.0 - 0.2 * of_two, kRounding);
  EXPECT_DOUBLE_EQ(model.error({1, 0, 4}), 1.0 - 0.16 * 0.75);
  EXPECT_NEAR(model.error({4, 1, 4}), 1.0 - 0.5 * of_four - 0.2 * of_two - 0.12, kRounding);
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

// The noise .25 + .75 n^-1.3 times the cost .9 + .1 n is .486, .480 and .485 for n = 4, 5 and 6.
TEST(SampleModel, BestNumberOfLightSamplesHasTheSmallestProduct) {
  const SampleModel model{.of_lights = 0.75, .light_cost = 0.1};
  EXPECT_EQ(best_counts(model, {.lights = true}).lights, 5);
}

TEST(SampleModel, SmallGainsChangeNothing) {
  const SampleCounts best =
      best_counts({.of_lights = 0.02, .of_reflections = 0.01, .of_sharing = 0.02, .pixel_cost = 0.001}, kAllOpen);
  EXPECT_EQ(best.lights, 1);
  EXPECT_EQ(best.reflections, 0);
  EXPECT_EQ(best.pixels, 1);
}

TEST(SampleModel, LightSamplesThatCostLittleAreAsManyAsMayBeChosen) {
  const SampleModel model{.of_lights = 0.9, .light_cost = 0.001};
  EXPECT_EQ(best_counts(model, {.lights = true}).lights, kMaxChosenDirectSamples);
}

// Sharing takes a tenth of the noise away beside one light sample, and two fifths beside eight.
TEST(SampleModel, SharingPaysBesideLightSamples) {
  SampleModel model{.of_lights = 0.85, .of_sharing = 0.12, .light_cost = 0.02, .sharing_cost = 0.1};
  EXPECT_EQ(best_counts(model, {.pixels = true}).pixels, 1);
  const SampleCounts best = best_counts(model, {.lights = true, .pixels = true});
  EXPECT_EQ(best.pixels, 8);
  EXPECT_GT(best.lights, 4);
  model.sharing_cost = 2.5;
  EXPECT_EQ(best_counts(model, {.lights = true, .pixels = true}).pixels, 1);
}

} // namespace
} // namespace kindling::test
