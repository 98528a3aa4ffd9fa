// Training of a path guide: traces paths ahead of the image and learns a guide from them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/guiding/guide.h"
#include "renderer/integrator/integrator.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace kindling {

struct GuideTrainingSettings {
  IntegratorSettings integrator; // of the path tracer that is to be guided
  PixelFilter filter;
  uint32_t seed = 0;      // of the render; the paths of the training are independent of its samples
  uint64_t max_paths = 0; // 0: no training
  uint32_t samples = 1;   // that the render takes of each pixel
  // Wall seconds for tracing and learning. The speed is measured with paths that are dropped, then
  // max_paths lowered to what the time allows (GuidingStatistics::max_paths). Unset: no limit.
  std::optional<double> max_training_s;
  bool only_if_worthwhile = true; // false: train to the end and use any predicted gain
  std::vector<PixelRect> blocks;  // of the whole image, kBlockSize on a side, in scan order
};

// Cost and result of a training; all zero if there was none.
struct GuidingStatistics {
  double training_s = 0.0; // wall seconds
  uint64_t max_paths = 0;  // GuideTrainingSettings::max_paths, or what its time allowed
  uint64_t paths = 0;
  RayCounters rays;                   // of the training's paths
  double predicted = 1.0;             // second moment of reflected light with the guide, relative to that without
  double predicted_environment = 1.0; // with directions that follow the environment
  double predicted_lights = 1.0;      // the same for light samples
  int patches = 0;                    // that directions are guided to; 0: directions are not guided
  int environment_regions = 0;        // where directions follow the environment; 0: none do
  int light_regions = 0;              // with learned probabilities of the kinds of light; 0: none are learned
  int volume_regions = 0;             // of scattering media with learned directions; 0: none
  int caustic_regions = 0;            // of surfaces with learned directions of caustics; 0: none
  double caustic_share = 0.0;         // of the image's light that these find, as predicted
};

struct TrainedGuide {
  std::unique_ptr<const Guide> guide; // null: render without a guide
  GuidingStatistics statistics;
  double busy_s = 0.0; // time spent tracing paths, summed over the threads; the rest is learning and waiting
};

// Traces an eighth of the paths first, as a probe that predicts the gain, then the rest, guided by
// what the probe learned; then up to as many light paths into scattering media, and up to twice as
// many over casters if it pays. The guide is a function of world, camera, settings and
// GuidingStatistics::max_paths: threads do not change it. Runs on the threads of the current TBB
// arena. `stopped` is polled between blocks and may be empty; once it returns true, no guide is
// returned. `on_done` may be empty; it is called from any thread with the number of paths traced so
// far.
[[nodiscard]] TrainedGuide train_guide(const World& world, const Camera& camera, const GuideTrainingSettings& settings,
                                       const std::function<bool()>& stopped,
                                       const std::function<void(uint64_t)>& on_done);

} // namespace kindling
