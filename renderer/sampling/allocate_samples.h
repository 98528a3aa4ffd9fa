// Allocates samples to pixels: more where there is more noise for the cost.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

// The noise of the pixels of a rectangle, rows from the top.
struct NoiseMap {
  // Units of relative_variance. Whole numbers, so that sums do not depend on the rectangle.
  static constexpr double kVarianceUnit = 1.0 / (1U << 20);

  V2i corner{0, 0};
  int width = 0, height = 0;
  std::vector<uint32_t> relative_variance; // of one sample's luminance
  std::vector<float> cost;                 // of one sample, above 0
};

// The means of a group of pixels.
struct GroupNoise {
  double relative_variance = 0.0;
  double cost = 1.0;
};

// The rule by which rates follow from noise. n samples leave a pixel of variance v the squared
// error v / n, and cost c n. The sum of the errors is least for a given sum of costs if n is in
// proportion to sqrt(v / c).
struct RateRule {
  double scale = 0.0;  // samples are scale * sqrt(v / c) for each planned level; 0: not used
  double levels = 0.0; // planned, with the pilot, which is subtracted
};

// The predicted ratio of errors from which on rates pay: they are themselves estimates, and numbers
// of samples that are no powers of two fill fewer strata.
inline constexpr double kMinRatesGain = 1.25;

// Returns the rule for which groups of equal size cost as much as at a rate of 1 everywhere, within
// the bounds of rates (SampleRates); a scale of 0 if that would divide the error by less than
// min_gain. levels: more than those of the pilot.
[[nodiscard]] RateRule rate_rule(std::span<const GroupNoise> groups, double levels, double min_gain = kMinRatesGain);

// Returns the rates of the pixels of a rectangle inside of the map, rows from the top, in 1 /
// SampleRates::kUnit. The map has at least kAllocationMargin pixels around the rectangle, or as
// many as the image has.
//
// A pixel's variance is estimated from its neighbors: the geometric mean of the means over 5 x 5
// and 13 x 13 pixels, each without the pixel itself. So its rate does not depend on its own
// samples, and their mean is unbiased. Deciding by the samples that are averaged is not (Kirk and
// Arvo 1991, "Unbiased Sampling Techniques for Image Synthesis").
inline constexpr int kAllocationMargin = 6;
[[nodiscard]] std::vector<uint8_t> allocate_samples(const NoiseMap& noise, const V2i& corner, int width, int height,
                                                    const RateRule& rule);

} // namespace kindling
