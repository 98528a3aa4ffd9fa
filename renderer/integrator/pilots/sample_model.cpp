// Looks for the numbers with the smallest product of noise and cost.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/sample_model.h"

#include "renderer/base/elementary.h"
#include "renderer/integrator/integrator_settings.h"
#include "renderer/integrator/path_reuse.h"

#include <algorithm>

namespace kindling {
namespace {

// The best numbers so far.
struct Best {
  const SampleModel& model;
  SampleCounts counts = model.first;
  double product = 1.0;

  // Tries some light samples, with any reflection samples that are open, at this number of pixels.
  void try_lights(int min, int max, const OpenCounts& open, int pixels, double max_product) {
    const auto try_all = [&](int reflections) {
      for (int lights = min; lights <= max; ++lights) {
        const SampleCounts tried{lights, reflections, pixels};
        const double tried_product = model.product(tried);
        if (tried_product <= max_product && tried_product < product) {
          counts = tried;
          product = tried_product;
        }
      }
    };
    try_all(model.first.reflections);
    if (!open.reflections) return;
    max_product = std::min(max_product, product / kMinReflectionSampleGain);
    for (const int reflections : {1, 2, kMaxReflectionSamples}) try_all(reflections);
  }

  // Tries all numbers of samples at this number of pixels.
  void try_pixels(int pixels, const OpenCounts& open, double max_product) {
    const SampleCounts& first = model.first;
    if (!open.lights) return try_lights(first.lights, first.lights, open, pixels, max_product);
    try_lights(first.lights, kMaxChosenDirectSamples, open, pixels, max_product);
  }
};

} // namespace

// Not by the C library, whose last bits differ between machines.
double noise_of_samples(int count) {
  return static_cast<double>(elementary::pow(static_cast<float>(count), -kSampleExponent));
}

double SampleModel::error(const SampleCounts& counts) const {
  return 1.0 - of_lights * (noise_of_samples(first.lights) - noise_of_samples(counts.lights)) -
         of_reflections * (noise_of_samples(1 + first.reflections) - noise_of_samples(1 + counts.reflections)) -
         of_sharing * (1.0 / first.pixels - 1.0 / counts.pixels);
}

double SampleModel::cost(const SampleCounts& counts) const {
  const double sharing = counts.pixels > 1 && first.pixels == 1 ? sharing_cost : 0.0;
  return 1.0 + light_cost * (counts.lights - first.lights) +
         reflection_cost * (counts.reflections - first.reflections) + sharing +
         pixel_cost * (counts.pixels - first.pixels);
}

SampleCounts best_counts(const SampleModel& model, const OpenCounts& open) {
  Best best{model};
  best.try_pixels(model.first.pixels, open, 1.0 / kMinDirectSampleGain);
  if (!open.pixels) return best.counts;
  const double max_product = best.product / kMinPathReuseGain;
  for (int pixels = 2; pixels <= static_cast<int>(kMaxPathReuse); pixels *= 2)
    best.try_pixels(pixels, open, max_product);
  return best.counts;
}

} // namespace kindling
