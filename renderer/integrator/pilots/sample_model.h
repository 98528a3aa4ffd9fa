// Predicts noise and cost by the numbers of samples that pilots choose.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

namespace kindling {

// Light samples and reflection samples at a path's first surface, and pixels that share their
// paths.
struct SampleCounts {
  int lights = 1, reflections = 0, pixels = 1;
};

// The numbers that may be chosen.
struct OpenCounts {
  bool lights = false, reflections = false, pixels = false;
};

// Returns the part of the noise of one sample that so many have together: less than 1 / count, as
// they are stratified among each other. On 25 scenes the noise of light samples fell with powers of
// .65 to 1.75, of 1.2 in the mean.
[[nodiscard]] double noise_of_samples(int count);
inline constexpr float kSampleExponent = 1.3f;

// Noise is a + b n(lights) + s n(1 + reflections) + i / pixels with n = noise_of_samples(), as a
// path takes one direction itself; the cost rises by the same for each one more. All is relative to
// the first setting.
struct SampleModel {
  SampleCounts first;
  double of_lights = 0.0, of_reflections = 0.0, of_sharing = 0.0; // b, s and i
  std::optional<double> of_indirect; // light reflected more than once, of which i is a part; none: not measured
  double light_cost = 0.0, reflection_cost = 0.0; // of one more
  double sharing_cost = 0.0, pixel_cost = 0.0;    // of any sharing, and of one more pixel

  [[nodiscard]] double error(const SampleCounts& counts) const;
  [[nodiscard]] double cost(const SampleCounts& counts) const;
  [[nodiscard]] double product(const SampleCounts& counts) const { return error(counts) * cost(counts); }
};

// Returns the numbers with the smallest error times cost. Numbers that cost more must gain: those
// of light samples kMinDirectSampleGain over the first setting, reflection samples
// kMinReflectionSampleGain over none, and sharing kMinPathReuseGain over none.
[[nodiscard]] SampleCounts best_counts(const SampleModel& model, const OpenCounts& open);

inline constexpr int kMeasuredDirectSamples = 8;
inline constexpr int kMaxChosenDirectSamples = 16;
inline constexpr double kMinDirectSampleGain = 1.05;
inline constexpr double kMinReflectionSampleGain = 1.03;
inline constexpr double kMinPathReuseGain = 1.05;

} // namespace kindling
