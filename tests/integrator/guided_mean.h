// Renders with given and learned guides: their means, noise and bits.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/hash.h"
#include "renderer/guiding/guide.h"
#include "tests/integrator/test_scenes.h"
#include "tests/session/same_bits.h"

#include <vector>

namespace kindling::test {

// Returns the settings of a render that trains its guide with so many paths.
inline RenderSettings trained_render(const V2i& size, uint32_t samples, Guiding guiding, uint64_t training_paths) {
  RenderSettings settings = small_render(size, samples);
  settings.guiding = guiding;
  settings.training_paths = training_paths;
  settings.integrator.direct_samples = 1;
  return settings;
}

// Returns a number in [-1, 1), for arbitrary guides: another one for each i and salt.
inline float arbitrary(uint32_t i, uint32_t salt) { return 2.0f * to_unit_float(hash_u32(i + (salt << 20))) - 1.0f; }

// Returns the variance of an image's pixels, relative to the squares of their luminances in another
// image, summed: bright places, which paths find by themselves, count little.
inline double relative_variance(const Film& film, const Film& reference) {
  const std::vector<float> variance = film.resolve(Aov::variance), beauty = reference.resolve(Aov::beauty);
  double sum = 0.0;
  for (size_t i = 0; i < variance.size(); ++i) {
    const float mean = luminance(Rgb(beauty[3 * i], beauty[3 * i + 1], beauty[3 * i + 2]));
    sum += static_cast<double>(variance[i]) / static_cast<double>(square(mean));
  }
  return sum;
}

// Renders with one thread and with three, expects the same bits, and returns the guide's
// statistics.
inline GuidingStatistics render_on_any_threads(const World& world, const Camera& camera, RenderSettings settings) {
  settings.threads = 1;
  const Result<RenderOutcome> alone = render(world, camera, settings, nullptr, nullptr);
  settings.threads = 3;
  const Result<RenderOutcome> together = render(world, camera, settings, nullptr, nullptr);
  if (!alone.ok() || !together.ok()) {
    ADD_FAILURE() << "a render failed";
    return {};
  }
  expect_same_bits(together.value().film, alone.value().film, "three threads");
  return alone.value().statistics.guiding;
}

// Renders all pixels of an image, with or without a guide.
inline Mean guided_mean(const World& world, const Camera& camera, const RenderSettings& settings, const Guide* guide) {
  const auto integrator = make_integrator(settings.integrator, world, camera, Sampler(settings.seed), settings.filter,
                                          settings.aovs, guide);
  const auto context = integrator->make_context();
  Film film(settings.size_px, PixelRect{V2i(0, 0), settings.size_px}, settings.aovs);
  for (int y = 0; y < settings.size_px.y; y += kBlockSize)
    for (int x = 0; x < settings.size_px.x; x += kBlockSize)
      integrator->render_block(PixelRect{V2i(x, y), V2i(x + kBlockSize, y + kBlockSize)},
                               {0, settings.samples_per_pixel}, *context, film);
  EXPECT_EQ(context->counters.non_finite, 0U);
  return mean_of(film);
}

} // namespace kindling::test
