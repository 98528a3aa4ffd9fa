// The Integrator interface, which turns samples of pixels into radiance; counters.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/camera/camera.h"
#include "renderer/film/film.h"
#include "renderer/integrator/aov_inputs.h"
#include "renderer/integrator/integrator_settings.h"
#include "renderer/integrator/whitted_counters.h"
#include "renderer/sampling/pixel_filter.h"
#include "renderer/sampling/sample_range.h"
#include "renderer/sampling/sample_rates.h"
#include "renderer/sampling/sampler.h"
#include "renderer/world/world.h"

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace kindling {

struct Guide;

// Counts of one thread, summed over all threads at the end.
struct RayCounters {
  uint64_t camera = 0;
  uint64_t bounce = 0;
  uint64_t shadow = 0;
  uint64_t photon = 0; // of light paths to photon maps; not in total(), since any thread may trace them
  uint64_t paths = 0;
  uint64_t outside = 0; // of total(): rays of light paths that belong to pixels outside of the crop
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
  Rgb radiance{0.0f};           // the sample's sum so far
  std::array<int, 3> bounces{}; // of a path so far: diffuse, glossy, and transmissions
};
using PathTrace = std::vector<PathVertex>;
// PathVertex::event of the end of a path that is shared between pixels, which is at no place: its
// radiance includes what the paths of the others have brought.
inline constexpr std::string_view kJoinedEvent = "joined to paths of other pixels";

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

// Samples of all pixels of one block, and what was done of them. The block has at least one pixel
// and lies within one block of the grid.
struct BlockWork {
  PixelRect block;
  SampleRange samples; // levels, if there are rates
  // Null: each pixel has the same samples. Path tracers alone support others.
  const SampleRates* rates = nullptr;
  bool counts_rays = false; // whether `rays` must be set; then the block is a batch of its own
  uint32_t added = 0;       // samples of each pixel, or levels, that were added to the film, the first ones
  uint64_t rays = 0;        // traced for them, without RayCounters::outside
};

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
  // render_block() for the levels of `rates`; 0 if the integrator supports none.
  virtual uint32_t render_levels(const PixelRect& /*block*/, const SampleRange& /*levels*/,
                                 const SampleRates& /*rates*/, ThreadContext& /*context*/, Film& /*film*/) const {
    return 0;
  }
  // The maximum number of samples that a pass over the image should have.
  [[nodiscard]] virtual uint32_t samples_per_pass() const { return std::numeric_limits<uint32_t>::max(); }
  // The number of paths that render_blocks() can follow together; 0: those of one block.
  [[nodiscard]] virtual uint64_t paths_together() const { return 0; }
  // True if the paths are those of a device, which one thread commands.
  [[nodiscard]] virtual bool on_device() const { return false; }
  // The same for several blocks, which are different; sets what was done.
  virtual void render_blocks(std::span<BlockWork> work, ThreadContext& context, Film& film) const;
};

// Makes the integrator that settings.kind names. `guide` is used by the path tracer alone and may
// be null.
[[nodiscard]] std::unique_ptr<Integrator> make_integrator(const IntegratorSettings& settings, const World& world,
                                                          const Camera& camera, const Sampler& sampler,
                                                          const PixelFilter& filter, AovSet aovs,
                                                          const Guide* guide = nullptr, const AovInputs& inputs = {});

} // namespace kindling
