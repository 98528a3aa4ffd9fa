// The Integrator interface, which turns samples of pixels into radiance; settings and counters.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/camera/camera.h"
#include "renderer/film/film.h"
#include "renderer/integrator/caustics.h"
#include "renderer/integrator/sample_range.h"
#include "renderer/integrator/whitted_settings.h"
#include "renderer/sampling/pixel_filter.h"
#include "renderer/sampling/sampler.h"
#include "renderer/world/world.h"

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

struct Guide;

enum class IntegratorKind : uint8_t {
  path,
  whitted,
  ambient_occlusion,
  albedo,
  normal,
  geometric_normal,
  depth,
  uv,
  barycentric,
  instance,
  material
};
[[nodiscard]] std::string_view integrator_name(IntegratorKind kind);
[[nodiscard]] std::optional<IntegratorKind> integrator_from_name(std::string_view name);
[[nodiscard]] std::span<const IntegratorKind> all_integrators();

struct IntegratorSettings {
  IntegratorKind kind = IntegratorKind::path;
  int max_bounces = 8; // reflections of a path after its first surface, diffuse and glossy; 0: direct light only
  int max_diffuse_bounces = 8;
  int max_glossy_bounces = 8;
  int max_transmission_bounces = 16;   // counted apart: a glass has four surfaces, and one behind another is common
  int roulette_start_bounce = 2;       // first bounce with Russian roulette
  float clamp_direct = kInfinity;      // maximum of any component of a sample's directly lit part
  float clamp_indirect = kInfinity;    // the same for light that was reflected more than once
  Caustics caustics = Caustics::full;  // treatment of light found through narrow lobes behind wide ones
  float ao_distance_m = 0.0f;          // ambient occlusion: 0 means a tenth of the scene's diagonal
  bool environment_visible = true;     // to camera rays
  std::optional<Rgb> background;       // seen by camera rays in place of the environment, alpha 1
  bool transparent_background = false; // camera rays that leave give alpha 0
  uint32_t batch_size = 256;           // path states that a thread advances together, a multiple of 64
  WhittedSettings whitted; // for IntegratorKind::whitted, which ignores the limits, clamps and caustics above
};

// Counts of the Whitted tracer, by one thread.
struct WhittedCounters {
  uint64_t reflection = 0;   // rays; RayCounters::bounce includes them
  uint64_t transmission = 0; // likewise
  uint64_t cache_hits = 0;
  uint64_t cache_misses = 0;   // computed and stored
  uint64_t cache_bypasses = 0; // surfaces whose parameters vary over the material
};

// Counts of one thread, summed over all threads at the end.
struct RayCounters {
  uint64_t camera = 0;
  uint64_t bounce = 0;
  uint64_t shadow = 0;
  uint64_t paths = 0;
  WhittedCounters whitted;
  uint64_t non_finite = 0;                                  // samples dropped because their radiance was not finite
  std::optional<std::pair<V2i, uint32_t>> first_non_finite; // pixel and sample index, the smallest seen

  [[nodiscard]] uint64_t total() const { return camera + bounce + shadow; }
  void add(const RayCounters& other);
  void add_non_finite(const V2i& pixel, uint32_t sample_index);
};

// One vertex of a replayed path, in readable form.
struct PathVertex {
  int bounce = 0;
  std::string event; // "camera", "surface", "escaped", "absorbed", "roulette", ...
  V3f position{0.0f};
  V3f normal{0.0f};
  V3f direction{0.0f}; // of the ray that arrived here
  float distance = 0.0f;
  uint32_t instance = accel::kNoId;
  uint32_t mesh = accel::kNoId;
  uint32_t triangle = accel::kNoId;
  std::string material;
  Rgb throughput{1.0f};
  Rgb radiance{0.0f}; // the sample's sum so far
};
using PathTrace = std::vector<PathVertex>;

// All mutable state of one thread. Integrator::make_context() makes one per thread.
class ThreadContext {
 public:
  virtual ~ThreadContext() = default;
  RayCounters counters;
  PathTrace* trace = nullptr; // set while one sample is replayed
};

// Side of a block of pixels. Blocks are aligned to the image's origin, so that the groups of rays
// that an accelerator receives do not depend on tiles or threads.
inline constexpr int kBlockSize = 8;

// An integrator is immutable and shared by all threads. References given at construction must
// outlive it.
class Integrator {
 public:
  virtual ~Integrator() = default;
  [[nodiscard]] virtual std::unique_ptr<ThreadContext> make_context() const = 0;
  // Renders samples of all pixels of `block` and adds them to the film, for each pixel in ascending
  // order. The block has at least one pixel and lies within one block of the grid. `context` must
  // come from make_context() of this integrator. Returns the number of samples of each pixel that
  // were added, the first ones: all, unless World::abandoned().
  virtual uint32_t render_block(const PixelRect& block, const SampleRange& samples, ThreadContext& context,
                                Film& film) const = 0;
};

// Makes the integrator that settings.kind names. `guide` is used by the path tracer alone and may
// be null.
[[nodiscard]] std::unique_ptr<Integrator> make_integrator(const IntegratorSettings& settings, const World& world,
                                                          const Camera& camera, const Sampler& sampler,
                                                          const PixelFilter& filter, AovSet aovs,
                                                          const Guide* guide = nullptr);

} // namespace kindling
