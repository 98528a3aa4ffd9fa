// Measures the noise of light samples at the first surface, and what more of them cost.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/direct_sample_pilot.h"

#include "renderer/integrator/path_integrator.h"
#include "renderer/integrator/pilots/pilot_grid.h"
#include "renderer/integrator/pilots/pilot_tasks.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>
#include <vector>

namespace kindling {
namespace {

// Two would measure the noise, but stratification over the samples of a pixel helps light samples
// more than whole paths, so that their share of the noise falls with the number of samples.
constexpr uint32_t kSamples = 8;
constexpr size_t kRuns = 2; // independent renders of a block
constexpr std::array<int, 2> kCounts{1, kMaxChosenDirectSamples};
constexpr int kSide = 4; // of a block, in pixels: many small blocks see more of the image
constexpr uint64_t kPathsPerBlock = kCounts.size() * kRuns * kSamples * kSide * kSide;
constexpr double kTrimmed = 0.005;   // share of the pixels that do not count: fireflies
constexpr double kFloorShare = 0.1;  // of the image's mean luminance: below, the absolute error counts
constexpr double kCameraCost = 0.75; // of a camera ray and its sample, in rays of bounces and shadows

// Luminance of the pixels of a block, by number of light samples and run.
using BlockLuminance = std::array<std::array<std::vector<double>, kRuns>, kCounts.size()>;

// Noise and cost, summed over the pilot.
struct Measured {
  std::array<double, kCounts.size()> error{};
  std::array<double, kCounts.size()> shadow_rays{};
  double other_cost = 0.0;
};

double square_of(double x) { return x * x; }

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

// Returns the squared relative errors of all pixels, summed for each number of light samples.
std::array<double, kCounts.size()> relative_errors(const std::vector<BlockLuminance>& blocks) {
  double sum = 0.0;
  for (const BlockLuminance& block : blocks) sum += mean_of(block[0][0]);
  const double floor = kFloorShare * sum / static_cast<double>(blocks.size());
  std::vector<std::array<double, kCounts.size()>> errors;
  for (const BlockLuminance& block : blocks) {
    const double scale2 = square_of(0.5 * (mean_of(block[0][0]) + mean_of(block[0][1]))) + square_of(floor);
    if (!(scale2 > 0.0)) continue;
    for (size_t pixel = 0; pixel < block[0][0].size(); ++pixel) {
      std::array<double, kCounts.size()>& error = errors.emplace_back();
      for (size_t i = 0; i < kCounts.size(); ++i)
        error[i] = square_of(block[i][0][pixel] - block[i][1][pixel]) / scale2;
    }
  }
  std::sort(errors.begin(), errors.end(),
            [](const auto& a, const auto& b) { return std::pair(a[0] + a[1], a[0]) < std::pair(b[0] + b[1], b[0]); });
  errors.resize(static_cast<size_t>(static_cast<double>(errors.size()) * (1.0 - kTrimmed)));
  std::array<double, kCounts.size()> sums{};
  for (const auto& error : errors)
    for (size_t i = 0; i < kCounts.size(); ++i) sums[i] += error[i];
  return sums;
}

// Sets the number of samples, and what is predicted of it.
void choose(const Measured& measured, DirectSampleChoice& choice) {
  constexpr double kLast = kCounts.back();
  const double all = measured.error[0];
  if (!(all > 0.0)) return;
  // all = a + b, error[1] = a + b / kLast
  const double direct = std::clamp((all - measured.error[1]) / (1.0 - 1.0 / kLast), 0.0, all);
  const double one_more = std::max(measured.shadow_rays[1] - measured.shadow_rays[0], 0.0) / (kLast - 1.0);
  const double cost = measured.other_cost + measured.shadow_rays[0];
  for (int samples = 2; samples <= kMaxChosenDirectSamples; ++samples) {
    const double product =
        (all - direct + direct / samples) / all * (cost + one_more * static_cast<double>(samples - 1)) / cost;
    if (product * kMinDirectSampleGain > 1.0 || product >= choice.predicted) continue;
    choice.predicted = product;
    choice.samples = samples;
  }
}

} // namespace

DirectSampleChoice choose_direct_samples(const World& world, const Camera& camera,
                                         const DirectSamplePilotSettings& settings,
                                         const std::function<bool()>& stopped) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  DirectSampleChoice choice;
  if (settings.paths < kPathsPerBlock) return choice;
  const V2i size_px = camera.size_px();
  const PilotGrid grid = make_pilot_grid(size_px, settings.paths / kPathsPerBlock, kSide);
  std::vector<BlockLuminance> blocks(grid.blocks.size());
  Measured measured;
  bool complete = true;
  for (size_t count = 0; count < kCounts.size() && complete; ++count)
    for (size_t run = 0; run < kRuns && complete; ++run) {
      IntegratorSettings one = settings.integrator;
      one.direct_samples = kCounts[count];
      one.light_paths = 0.0f;
      one.photons = 0.0f;
      one.light_groups = LightGrouping::off;
      const Sampler sampler(hash_combine(hash_u32(settings.seed ^ 0xa54ff53aU), static_cast<uint32_t>(run)));
      const PathIntegrator integrator(one, world, camera, sampler, settings.filter, AovSet{}, settings.guide);
      const PilotWork work =
          run_pilot_tasks(integrator, world, stopped, grid.blocks.size(), [&](size_t number, PathContext& context) {
            Film film(size_px, grid.blocks[number], AovSet{});
            if (integrator.render_block(grid.blocks[number], {0, kSamples}, context, film) < kSamples) return;
            std::vector<float> rgb;
            // Else this thread would take another task meanwhile.
            tbb::this_task_arena::isolate([&] { rgb = film.resolve(Aov::beauty); });
            std::vector<double>& luminances = blocks[number][count][run];
            for (size_t i = 0; i < rgb.size(); i += 3)
              luminances.push_back(static_cast<double>(luminance({rgb[i], rgb[i + 1], rgb[i + 2]})));
          });
      complete = work.complete;
      choice.rays.add(work.rays);
      choice.busy_s += work.busy_s;
      measured.shadow_rays[count] += static_cast<double>(work.rays.shadow);
      if (count == 0)
        measured.other_cost +=
            kCameraCost * static_cast<double>(work.rays.camera) + static_cast<double>(work.rays.bounce);
    }
  if (complete) {
    for (const PixelRect& block : grid.blocks)
      choice.paths += static_cast<uint64_t>(block.pixel_count()) * kCounts.size() * kRuns * kSamples;
    measured.error = relative_errors(blocks);
    choose(measured, choice);
  }
  choice.pilot_s = std::chrono::duration<double>(Clock::now() - start).count();
  return choice;
}

} // namespace kindling
