// Brightness of films and the exposure that follows, against values computed by hand.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/film/exposure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace kindling {
namespace {

// A row of gray pixels of these values.
Film row(const std::vector<float>& values, float alpha = 1.0f) {
  const int width = static_cast<int>(values.size());
  Film film({width, 1}, {{0, 0}, {width, 1}}, {});
  for (int x = 0; x < width; ++x) film.add({x, 0}, {Rgb(values[static_cast<size_t>(x)]), alpha, 1.0f});
  return film;
}

// Luminance sums three rounded products of single precision.
constexpr double kRounding = 4.0 * 0x1p-24;

TEST(Exposure, MeasuresMeanAndLogAverage) {
  const ImageBrightness brightness = measure_brightness(row({1.0f, 4.0f}));
  EXPECT_NEAR(brightness.mean, 2.5, 2.5 * kRounding);
  EXPECT_NEAR(brightness.log_average, 2.0, 2.0 * kRounding);
}

TEST(Exposure, DividesByAlphaAndIgnoresTransparentPixels) {
  Film film({2, 1}, {{0, 0}, {2, 1}}, {});
  film.add({0, 0}, {Rgb(0.25f), 0.5f, 1.0f});
  film.add({1, 0}, {Rgb(0.0f), 0.0f, 1.0f});
  EXPECT_NEAR(measure_brightness(film).mean, 0.5, 0.5 * kRounding);
  EXPECT_NEAR(measure_brightness(film).log_average, 0.5, 0.5 * kRounding);
}

TEST(Exposure, BlackPixelsLowerTheMeanOnly) {
  const ImageBrightness brightness = measure_brightness(row({0.0f, 2.0f, 1e-5f, 2.0f}));
  EXPECT_NEAR(brightness.mean, 1.0 + 0.25e-5, kRounding);
  EXPECT_NEAR(brightness.log_average, 2.0, 2.0 * kRounding);
}

TEST(Exposure, AutoMapsTheLogAverageToMiddleGray) {
  EXPECT_EQ(auto_exposure_stops(measure_brightness(row({0.18f, 0.18f}))), 0.0);
  EXPECT_EQ(auto_exposure_stops(measure_brightness(row({0.045f, 0.045f}))), 2.0);
  EXPECT_EQ(auto_exposure_stops(measure_brightness(row({1.44f}))), -3.0);
  EXPECT_EQ(auto_exposure_stops(measure_brightness(row({0.09f, 0.36f}))), 0.0);
}

TEST(Exposure, IsZeroForBlackAndBoundedForDarkImages) {
  EXPECT_EQ(auto_exposure_stops(measure_brightness(row({0.0f, 0.0f}))), 0.0);
  EXPECT_EQ(auto_exposure_stops(measure_brightness(row({1.0f}, 0.0f))), 0.0);
  EXPECT_EQ(auto_exposure_stops(measure_brightness(row({1e-9f}))), 16.0);
  EXPECT_EQ(auto_exposure_stops(measure_brightness(row({1e9f}))), -16.0);
}

} // namespace
} // namespace kindling
