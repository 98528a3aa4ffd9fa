// Renders images with many seeds, and trains guides for them.
// SPDX-License-Identifier: Apache-2.0
#include "tests/unbiased/render_images.h"

#include "renderer/integrator/pilots/light_path_pilot.h"
#include "renderer/session/find_sample_rates.h"
#include "renderer/session/place_integrator.h"
#include "renderer/session/prepare/train_guide.h"

#include <gtest/gtest.h>

namespace kindling::test {
namespace {

std::optional<SampleRates> rates_of(const RenderSettings& settings, const Integrator& integrator) {
  const PixelRect whole{V2i(0, 0), settings.size_px};
  RenderState dropped{Film(settings.size_px, whole, settings.aovs), Coverage(whole), {}, {}};
  return trace_pilot(
             settings, integrator, dropped, [] { return false; }, [](double) {})
      .rates;
}

// Finds the rule for an image that would be too small for a pilot.
void find_rate_rule(const World& world, const Camera& camera, const Guide* guide, RenderSettings& settings) {
  settings.rate_rule = choose_sample_rates(world, camera,
                                           {.integrator = settings.integrator,
                                            .filter = settings.filter,
                                            .guide = guide,
                                            .seed = settings.seed,
                                            .paths = 4096},
                                           settings.samples_per_pixel, settings.min_rates_gain, {})
                           .rule;
}

// A pilot for an image that would be too small for one.
LightPathPilotSettings pilot_of(const RenderSettings& settings) {
  return {.integrator = settings.integrator,
          .filter = settings.filter,
          .seed = settings.seed,
          .samples_per_pixel = settings.samples_per_pixel,
          .paths = 2048};
}

void render_block(BlockWork work, const Integrator& integrator, ThreadContext& context, Film& film) {
  integrator.render_blocks(std::span(&work, 1), context, film);
}

} // namespace

Images render_images(const World& world, const Camera& camera, RenderSettings settings, uint32_t first_seed,
                     uint32_t seeds, const Guide* guide) {
  const PixelRect whole{V2i(0, 0), camera.size_px()};
  Images images(camera.size_px());
  for (settings.seed = first_seed; settings.seed < first_seed + seeds; ++settings.seed) {
    if (settings.chooses_light_paths)
      settings.integrator.light_paths = choose_light_path_fraction(world, camera, pilot_of(settings), {}).fraction;
    if (settings.sample_rates == SampleRateKind::noise) find_rate_rule(world, camera, guide, settings);
    const auto integrator = make_integrator(settings.integrator, world, camera, make_sampler(settings), settings.filter,
                                            settings.aovs, guide);
    const auto context = integrator->make_context();
    Film film(camera.size_px(), whole, settings.aovs);
    if (settings.integrator.light_paths > 0.0f) film.enable_splats();
    const std::optional<SampleRates> rates =
        settings.rate_rule && settings.rate_rule->scale > 0.0 ? rates_of(settings, *integrator) : std::nullopt;
    for (int y = 0; y < whole.max.y; y += kBlockSize)
      for (int x = 0; x < whole.max.x; x += kBlockSize)
        render_block({.block = {V2i(x, y), V2i(x, y) + V2i(kBlockSize)},
                      .samples = {0, settings.samples_per_pixel},
                      .rates = rates ? &*rates : nullptr},
                     *integrator, *context, film);
    EXPECT_EQ(context->counters.non_finite, 0U);
    images.add(film.resolve(Aov::beauty));
  }
  return images;
}

std::unique_ptr<const Guide> train_one_guide(const World& world, const Camera& camera, RenderSettings settings) {
  settings.guiding = Guiding::on;
  settings.samples_per_pixel = 1024;
  settings.seed = 1U << 20; // different from those of all images
  return train_guide(world, camera, settings, nullptr, {}).guide;
}

} // namespace kindling::test
