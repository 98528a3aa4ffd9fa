// Noise and rays of several settings of the path tracer, measured on blocks all over an image.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/camera/camera.h"
#include "renderer/integrator/integrator.h"
#include "renderer/integrator/photons/gathered_photon.h"
#include "renderer/sampling/pixel_filter.h"
#include "renderer/world/world.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace kindling {

struct Guide;
class PathIntegrator;

// The render that a pilot of samples is for.
struct SamplePilotSettings {
  IntegratorSettings integrator; // of the path tracer, without light paths
  PixelFilter filter;
  const Guide* guide = nullptr; // of the render; null: none
  uint32_t seed = 0;            // of the render; the pilot's paths are independent of its samples
  uint64_t paths = 0;           // about so many; 0: no pilot
};

// The choice of such a pilot, and its cost.
struct SampleChoice {
  int count = 1;          // chosen: 1, or what divides error times cost most
  double predicted = 1.0; // error times cost, relative to 1
  uint64_t paths = 0;     // of the pilot; 0: there was none
  RayCounters rays;       // of the pilot
  double pilot_s = 0.0;   // wall seconds
  double busy_s = 0.0;    // summed over the threads
};

// Returns the paths of a pilot that has up to twice as many blocks if the background fills much of
// the image. `lit`: share of the blocks that are not background.
[[nodiscard]] inline uint64_t paths_beside_background(uint64_t paths, double lit) {
  return static_cast<uint64_t>(static_cast<double>(paths) / std::max(lit, 0.5));
}

inline constexpr size_t kMaxNoiseSettings = 3;

// The blocks that a pilot renders, each with all settings and twice with any.
struct NoiseBlocks {
  int side = 0; // in pixels, at most kBlockSize
  uint32_t samples = 0;
  size_t settings = 2;    // at most kMaxNoiseSettings
  double trimmed = 0.005; // share of the pixels that do not count: fireflies
  double floor = 0.1;     // of the image's mean: below, the absolute error counts
  // The last setting has photons. They are noted, and errors are those of luminance, relative to
  // its blocks, which have fewer sparkles.
  bool notes_photons = false;

  [[nodiscard]] uint64_t paths_per_block() const {
    return uint64_t{2} * settings * samples * static_cast<uint64_t>(side * side);
  }
};

// The cost of a ray together with the work that comes with it, in any unit.
struct RayCosts {
  double camera = 0.0, bounce = 0.0, shadow = 0.0;
};

// In one more light sample at a first surface, with its shadow ray. Fitted to times of path tracing
// of 22 scenes.
inline constexpr RayCosts kSampleRayCosts{.camera = 1.0, .bounce = 3.0, .shadow = 1.0};

// Squared relative errors of the settings, the means of the channels, summed over the same pixels:
// of all light, of light that was reflected once or not at all, and of the rest.
struct NoiseErrors {
  std::array<double, kMaxNoiseSettings> all{}, direct{}, indirect{};

  void add(const NoiseErrors& other);
  // Returns twice the covariance of direct and indirect light.
  [[nodiscard]] double twice_covariance(size_t setting) const {
    return all[setting] - direct[setting] - indirect[setting];
  }
};

// Noise and cost of the settings.
struct MeasuredNoise {
  bool complete = false;              // neither stopped nor too few paths for a block
  std::vector<NoiseErrors> of_blocks; // those that are lit
  NoiseErrors error;                  // summed over the blocks
  std::array<double, kMaxNoiseSettings> shadow_rays{}, photon_rays{};
  double lit = 0.0; // share of the blocks whose paths sample a light
  // Those of the last setting, if NoiseBlocks::notes_photons; their luminance is relative to their
  // block.
  std::vector<GatheredPhoton> photons;
  double camera_rays = 0.0, bounce_rays = 0.0; // of the first setting, with the background's

  [[nodiscard]] double cost(const RayCosts& costs, size_t setting = 0) const { // without photons
    return costs.camera * camera_rays + costs.bounce * bounce_rays + costs.shadow * shadow_rays[setting];
  }
  // Adds the work and the noise of other blocks with the same settings; `complete` if both are.
  void add(const MeasuredNoise& other);
  [[nodiscard]] double more_shadow_rays() const { return std::max(shadow_rays[1] - shadow_rays[0], 0.0); }
};

// Measures the noise of several settings: settings.integrator as `change(_, number)` leaves it,
// which changes nothing of the paths themselves; photons may be gathered beside them. All settings
// have the same paths, so their differences in noise are those of the changes. `stopped` is polled
// between blocks and may be empty. Borrows all but `blocks` and `change`.
class NoiseSurvey {
 public:
  static constexpr size_t kRuns = 2; // independent renders of a block
  using Change = std::function<void(IntegratorSettings&, size_t)>;
  NoiseSurvey(const World& world, const Camera& camera, const SamplePilotSettings& settings, const NoiseBlocks& blocks,
              Change change, const std::function<bool()>& stopped);
  ~NoiseSurvey();

  // Renders blocks all over the image by about so many paths. Those that sample no light, the
  // background, are rendered once and do not count. Adds its cost to `choice`. Calls with other
  // numbers of paths have other blocks for the most part; photons are traced by the first call.
  //
  // A function of world, camera, settings and paths: threads do not change it. Runs on the threads
  // of the current TBB arena.
  [[nodiscard]] MeasuredNoise measure(uint64_t paths, SampleChoice& choice);

 private:
  class Part;

  [[nodiscard]] const PathIntegrator& integrator_of(size_t setting, size_t run);

  const World& world_;
  const Camera& camera_;
  const SamplePilotSettings& settings_;
  NoiseBlocks blocks_;
  Change change_;
  const std::function<bool()>& stopped_;
  std::array<std::array<std::unique_ptr<const PathIntegrator>, kRuns>, kMaxNoiseSettings> integrators_; // once used
};

} // namespace kindling
