// The mean of an image that is rendered with a given guide.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/guiding/guide.h"
#include "tests/integrator/test_scenes.h"

namespace kindling::test {

// Returns the settings of a render that trains its guide with so many paths.
inline RenderSettings trained_render(const V2i& size, uint32_t samples, Guiding guiding, uint64_t training_paths) {
  RenderSettings settings = small_render(size, samples);
  settings.guiding = guiding;
  settings.training_paths = training_paths;
  settings.integrator.direct_samples = 1;
  return settings;
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
