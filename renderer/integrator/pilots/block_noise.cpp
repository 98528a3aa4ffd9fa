// Renders the blocks of a pilot, and compares their noise.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/block_noise.h"

#include "renderer/integrator/path_integrator.h"
#include "renderer/integrator/pilots/pilot_grid.h"
#include "renderer/integrator/pilots/pilot_tasks.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

namespace kindling {
namespace {

constexpr size_t kRuns = 2;          // independent renders of a block
constexpr double kTrimmed = 0.005;   // share of the pixels that do not count: fireflies
constexpr double kFloorShare = 0.1;  // of the image's mean luminance: below, the absolute error counts
constexpr double kCameraCost = 0.75; // of a camera ray and its sample, in rays of bounces and shadows

// Luminance of the pixels of a block, by setting and run.
using BlockLuminance = std::array<std::array<std::vector<double>, kRuns>, kMaxNoiseSettings>;
using Errors = std::array<double, kMaxNoiseSettings>; // by setting

double square_of(double x) { return x * x; }

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

// Returns the squared relative errors of all pixels, summed for each setting.
Errors relative_errors(const std::vector<BlockLuminance>& blocks, size_t settings) {
  double sum = 0.0;
  for (const BlockLuminance& block : blocks) sum += mean_of(block[0][0]);
  const double floor = kFloorShare * sum / static_cast<double>(blocks.size());
  std::vector<Errors> errors;
  for (const BlockLuminance& block : blocks) {
    if (block[0][1].empty()) continue; // background
    const double scale2 = square_of(0.5 * (mean_of(block[0][0]) + mean_of(block[0][1]))) + square_of(floor);
    if (!(scale2 > 0.0)) continue;
    for (size_t pixel = 0; pixel < block[0][0].size(); ++pixel) {
      Errors& error = errors.emplace_back();
      for (size_t i = 0; i < settings; ++i) error[i] = square_of(block[i][0][pixel] - block[i][1][pixel]) / scale2;
    }
  }
  std::sort(errors.begin(), errors.end(),
            [](const Errors& a, const Errors& b) { return std::pair(a[0] + a[1], a) < std::pair(b[0] + b[1], b); });
  errors.resize(static_cast<size_t>(static_cast<double>(errors.size()) * (1.0 - kTrimmed)));
  Errors sums{};
  for (const Errors& error : errors)
    for (size_t i = 0; i < settings; ++i) sums[i] += error[i];
  return sums;
}

} // namespace

MeasuredNoise measure_noise(const World& world, const Camera& camera, const SamplePilotSettings& settings,
                            const NoiseBlocks& shape, const std::function<void(IntegratorSettings&, size_t)>& change,
                            const std::function<bool()>& stopped, SampleChoice& choice) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  MeasuredNoise measured;
  if (settings.paths < shape.paths_per_block()) return measured;
  const V2i size_px = camera.size_px();
  const PilotGrid grid = make_pilot_grid(size_px, settings.paths / shape.paths_per_block(), shape.side);
  std::vector<BlockLuminance> blocks(grid.blocks.size());
  std::vector<uint8_t> is_lit(grid.blocks.size(), 1); // after the first run: a path has sampled a light
  measured.complete = true;
  for (size_t setting = 0; setting < shape.settings && measured.complete; ++setting)
    for (size_t run = 0; run < kRuns && measured.complete; ++run) {
      IntegratorSettings one = settings.integrator;
      one.light_paths = 0.0f;
      one.photons = 0.0f;
      one.light_groups = LightGrouping::off;
      change(one, setting);
      const Sampler sampler(hash_combine(hash_u32(settings.seed ^ 0xa54ff53aU), static_cast<uint32_t>(run)));
      const PathIntegrator integrator(one, world, camera, sampler, settings.filter, AovSet{}, settings.guide);
      const PilotWork work =
          run_pilot_tasks(integrator, world, stopped, grid.blocks.size(), [&](size_t number, PathContext& context) {
            if (!is_lit[number]) return;
            const PixelRect& block = grid.blocks[number];
            const uint64_t shadow_rays = context.counters.shadow;
            Film film(size_px, block, AovSet{});
            if (integrator.render_block(block, {0, shape.samples}, context, film) < shape.samples) return;
            if (setting == 0 && run == 0) is_lit[number] = context.counters.shadow > shadow_rays ? 1 : 0;
            std::vector<float> rgb;
            // Else this thread would take another task meanwhile.
            tbb::this_task_arena::isolate([&] { rgb = film.resolve(Aov::beauty); });
            std::vector<double>& luminances = blocks[number][setting][run];
            for (size_t i = 0; i < rgb.size(); i += 3)
              luminances.push_back(static_cast<double>(luminance({rgb[i], rgb[i + 1], rgb[i + 2]})));
          });
      measured.complete = work.complete;
      choice.rays.add(work.rays);
      choice.paths += work.rays.paths;
      choice.busy_s += work.busy_s;
      measured.shadow_rays[setting] += static_cast<double>(work.rays.shadow);
      if (setting > 0) continue;
      measured.other_cost += static_cast<double>(work.rays.bounce);
      if (run == 0) measured.other_cost += kRuns * kCameraCost * static_cast<double>(work.rays.camera);
    }
  if (measured.complete) measured.error = relative_errors(blocks, shape.settings);
  choice.pilot_s = std::chrono::duration<double>(Clock::now() - start).count();
  return measured;
}

void choose_count(const MeasuredNoise& measured, std::span<const int> counts, const CountCost& cost, double min_gain,
                  SampleChoice& choice) {
  const double all = measured.error[0];
  if (!measured.complete || !(all > 0.0)) return;
  // all = a + b, error[1] = a + b / last
  const double falling = std::clamp((all - measured.error[1]) / (1.0 - 1.0 / counts.back()), 0.0, all);
  for (const int count : counts) {
    const double product =
        (all - falling + falling / count) / all * (1.0 + cost.fixed + cost.of_one_more * (count - 1));
    if (product * min_gain > 1.0 || product >= choice.predicted) continue;
    choice.predicted = product;
    choice.count = count;
  }
}

} // namespace kindling
