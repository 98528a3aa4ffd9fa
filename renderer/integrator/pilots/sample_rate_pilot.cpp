// Measures noise and cost of blocks, and finds the rule by which samples are divided.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/sample_rate_pilot.h"

#include "renderer/film/film.h"
#include "renderer/integrator/pilots/pilot_grid.h"
#include "renderer/integrator/pilots/pilot_tasks.h"
#include "renderer/sampling/sample_rates.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <span>
#include <vector>

namespace kindling {
namespace {

constexpr uint32_t kSamples = SampleRates::kPilotLevels;
constexpr int kBlockSide = 4;        // small, as many places say more than many pixels at one
constexpr double kFloorShare = 0.25; // of the image's mean luminance: below, the absolute error counts
constexpr double kCameraCost = 0.15; // of a camera ray and its sample, in rays of bounces and shadows

struct SurveyedBlock {
  std::vector<float> radiance;  // means of the pixels, RGB
  std::vector<float> variances; // of these means' luminance
  double cost = 1.0;            // of a sample
};

double pixel_luminance(const SurveyedBlock& block, size_t pixel) {
  const float* rgb = &block.radiance[pixel * 3];
  return static_cast<double>(luminance({rgb[0], rgb[1], rgb[2]}));
}

double mean_luminance(std::span<const SurveyedBlock> blocks) {
  double sum = 0.0, count = 0.0;
  for (const SurveyedBlock& block : blocks) {
    for (size_t pixel = 0; pixel < block.variances.size(); ++pixel) sum += std::max(pixel_luminance(block, pixel), 0.0);
    count += static_cast<double>(block.variances.size());
  }
  return sum / std::max(count, 1.0);
}

GroupNoise noise_of(const SurveyedBlock& block, double floor) {
  double sum = 0.0;
  for (size_t pixel = 0; pixel < block.variances.size(); ++pixel)
    sum +=
        relative_variance(pixel_luminance(block, pixel), kSamples * static_cast<double>(block.variances[pixel]), floor);
  return {sum / static_cast<double>(block.variances.size()), block.cost};
}

} // namespace

RateChoice choose_sample_rates(const World& world, const Camera& camera, const SamplePilotSettings& settings,
                               uint32_t planned, double min_gain, const std::function<bool()>& stopped) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  RateChoice choice;
  constexpr uint64_t kPathsPerBlock = uint64_t{kSamples} * kBlockSide * kBlockSide;
  if (settings.paths < kPathsPerBlock) return choice;
  const PilotGrid grid = make_pilot_grid(camera.size_px(), settings.paths / kPathsPerBlock, kBlockSide);
  IntegratorSettings integrator_settings = settings.integrator;
  integrator_settings.light_paths = 0.0f; // they have no part in the noise here
  integrator_settings.photons = 0.0f;
  integrator_settings.manifold_samples = 0;
  integrator_settings.light_groups = LightGrouping::off;
  AovSet aovs;
  aovs.insert(Aov::variance);
  const Sampler sampler(hash_u32(settings.seed ^ 0x3c6ef372U));
  const PathIntegrator integrator(integrator_settings, world, camera, sampler, settings.filter, aovs, settings.guide);
  std::vector<SurveyedBlock> blocks(grid.blocks.size());
  const PilotWork work =
      run_pilot_tasks(integrator, world, stopped, grid.blocks.size(), [&](size_t number, PathContext& context) {
        const PixelRect& rect = grid.blocks[number];
        Film film(camera.size_px(), rect, aovs);
        const uint64_t rays_before = context.counters.total();
        if (integrator.render_block(rect, {0, kSamples}, context, film) < kSamples) return;
        SurveyedBlock& block = blocks[number];
        // Else this thread would take another task meanwhile.
        tbb::this_task_arena::isolate([&] {
          block.radiance = film.resolve(Aov::beauty);
          block.variances = film.resolve(Aov::variance);
        });
        const double samples = static_cast<double>(rect.pixel_count()) * kSamples;
        block.cost = cost_of_sample(static_cast<double>(context.counters.total() - rays_before) / samples);
      });
  choice.rays = work.rays;
  choice.busy_s = work.busy_s;
  if (work.complete) {
    choice.paths = work.rays.paths;
    choice.rule.floor = kFloorShare * mean_luminance(blocks);
    std::vector<GroupNoise> groups;
    for (const SurveyedBlock& block : blocks) groups.push_back(noise_of(block, choice.rule.floor));
    choice.rule.scale = rate_scale(groups, planned, min_gain, choice.predicted);
  }
  choice.pilot_s = std::chrono::duration<double>(Clock::now() - start).count();
  return choice;
}

double cost_of_sample(double rays) { return std::max(rays - 1.0, 0.0) + kCameraCost; }

} // namespace kindling
