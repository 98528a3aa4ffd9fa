// Allocates samples to pixels: more where there is more noise for the cost.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/sampling/sample_rates.h"

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

// The mean noise of a group of pixels.
struct GroupNoise {
  double relative_variance = 0.0;
  double cost = 1.0;
};

// The rule by which numbers of samples follow from noise. n samples leave a pixel of variance v the
// squared error v / n, and cost c n. The sum of the errors is least for a given sum of costs if n
// is in proportion to sqrt(v / c).
struct RateRule {
  double scale = 0.0; // a pixel has about scale * sqrt(v / c) times the planned samples; 0: all pixels have as many
  double floor = 0.0; // luminance below which the absolute error counts (relative_variance())
  [[nodiscard]] SampleRateKind kind() const { return scale > 0.0 ? SampleRateKind::noise : SampleRateKind::even; }
  bool operator==(const RateRule&) const = default;
};

// Rates are used if they are predicted to divide the error by more than this. The prediction is an
// estimate, and rates have costs of their own.
inline constexpr double kMinRatesGain = 1.25;

// Returns the scale for which groups of equal size take about as long as with `planned` samples of
// each pixel, within the bounds of SampleRates; 0 if that would divide the error by less than
// min_gain. `predicted` is set to the error that the best numbers would leave, relative to that.
// planned: more than the pilot's levels.
[[nodiscard]] double rate_scale(std::span<const GroupNoise> groups, uint32_t planned, double min_gain,
                                double& predicted);

// Returns the variance of one sample relative to a pixel's squared mean, both of luminance and
// measured with SampleRates::kPilotLevels samples.
[[nodiscard]] double relative_variance(double mean, double variance, double floor);

// Returns the logarithms of the numbers of samples of the pixels of a rectangle inside of the map,
// rows from the top, for SampleRates. The map has at least kAllocationMargin pixels around the
// rectangle, or as many as the image has.
//
// A pixel's variance is estimated from its neighbors: the geometric mean of the means over 5 x 5
// and 13 x 13 pixels, each without the pixel itself. So its number does not depend on its own
// samples, and their mean is unbiased. Deciding by the samples that are averaged is not (Kirk and
// Arvo 1991, "Unbiased Sampling Techniques for Image Synthesis").
inline constexpr int kAllocationMargin = 6;
[[nodiscard]] std::vector<uint8_t> allocate_samples(const NoiseMap& noise, const V2i& corner, int width, int height,
                                                    uint32_t planned, const RateRule& rule);

} // namespace kindling
