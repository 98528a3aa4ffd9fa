// Light paths: from lights over mirrors and glass to surfaces, joined to the camera there.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/film.h"
#include "renderer/integrator/integrator_settings.h"
#include "renderer/integrator/photons/photon_map_sizes.h"
#include "renderer/integrator/stages/light_path_stages.h"
#include "renderer/light/emission_sampling.h"
#include "renderer/sampling/pixel_filter.h"
#include "renderer/sampling/sample_range.h"
#include "renderer/world/light_groups/light_groups_view.h"
#include "renderer/world/world.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace kindling {

struct RayCounters;

// One thread's light paths of a batch.
struct LightPathContext {
  // Light that a ray from the camera finds unless something is in between.
  struct Splat {
    V2f film_px;
    Rgb radiance;              // times square pixels
    float ratio = 0.0f;        // of the densities of light paths and paths from the camera, for the weight
    float traced_ratio = 0.0f; // the same for paths as they are traced; only if measured
    SplatParts parts;          // only if split
  };

  std::vector<LightPathState> paths;
  std::vector<float> arriving;  // by path, if measured: density of light paths at the first caster, per square meter
  std::vector<uint32_t> active; // indices of paths, parallel to rays
  std::vector<accel::Ray> rays;
  std::vector<accel::Hit> hits;
  std::vector<Splat> splats; // parallel to camera_rays
  std::vector<accel::Ray> camera_rays;
  std::vector<uint8_t> occluded;
  std::vector<Splat> found;                // of all paths
  bool measures = false;                   // finds Splat::traced_ratio, for a pilot
  const LightGroupsView* splits = nullptr; // finds Splat::parts and Photon::group; there may be no groups
  std::vector<Photon>* photons = nullptr;  // set while paths leave photons and are not joined to the camera
};

// Traces light paths in addition to those from the camera (Arvo 1986, "Backward Ray Tracing"; Veach
// 1997, section 8.3): light that lamps and suns throw through glass and off metal onto other
// surfaces, as the camera sees it directly. Paths belong to samples of pixels, whichever pixels
// they reach, so that any division of the samples gives the same sums. What happens to a path is in
// stages/; this class owns what the stages read and leads batches of paths.
class LightPaths : public LightPathStages {
 public:
  // The camera and the world must outlive this.
  LightPaths(const IntegratorSettings& settings, const World& world, const Camera& camera, const PixelFilter& filter,
             uint32_t seed);

  // False if no light reaches a caster: there is nothing to trace.
  [[nodiscard]] bool useful() const { return !emission.empty(); }
  // Traces the light paths of these samples of blocks, and of their shares of the pixels outside of
  // the crop; then add_to() adds what they found to the film. `stages` are those of the camera's
  // paths.
  void trace(const PathStages& stages, std::span<const PixelRect> blocks, const SampleRange& samples,
             LightPathContext& context, RayCounters& counters) const;
  void add_to(std::span<const PixelRect> blocks, const SampleRange& samples, const LightPathContext& context,
              Film& film) const;
  // Returns the sizes of the photon maps.
  [[nodiscard]] PhotonMapSizes photon_maps() const {
    return {static_cast<uint64_t>(photons_per_pass) * samples_per_map, samples_per_map};
  }
  // Appends the photons of light paths by their numbers; these are others than those of trace().
  void trace_photons(const PathStages& stages, uint64_t first, uint64_t count, LightPathContext& context,
                     std::vector<Photon>& photons, RayCounters& counters) const;
  // Traces light paths by their numbers, which belong to no samples.
  void trace_numbers(const PathStages& stages, uint64_t first, uint64_t count, LightPathContext& context,
                     RayCounters& counters) const;

 private:
  static void clear_paths(LightPathContext& context);
  static void clear(LightPathContext& context);
  void start_block(const PixelRect& block, uint32_t pass, LightPathContext& context) const;
  void start_path(uint64_t number, LightPathContext& context) const;
  void trace_outside(const PathStages& stages, const OutsidePixels::Range& share, uint32_t pass,
                     LightPathContext& context, RayCounters& counters) const;
  void follow(const PathStages& stages, LightPathContext& context, RayCounters& counters) const;
  // Moves a path on from its hit. True if it continues with the ray that replaces `ray`.
  bool scatter_path(const PathStages& stages, const accel::Hit& hit, accel::Ray& ray, uint32_t number,
                    LightPathContext& context) const;
  [[nodiscard]] float arriving_density(const EmittedRay& emitted, const V3f& at) const;
  [[nodiscard]] float traced_ratio(const PathStages& stages, const SurfacePoint& surface, const accel::Hit& hit,
                                   const accel::Ray& ray, const LightPathState& path, float arriving,
                                   const LightJoint& joint) const;
  void keep_visible(LightPathContext& context, RayCounters& counters) const;

  const World& world_;
  PixelFilter filter_;
  std::optional<EmissionSampling> sampling_;
  std::vector<uint8_t> caster_flags_;
  float fraction_; // of the samples that have a light path
};

// Returns the light paths of a render; null if there are none to trace.
[[nodiscard]] std::unique_ptr<LightPaths> make_light_paths(const IntegratorSettings& settings, const World& world,
                                                           const Camera& camera, const PixelFilter& filter,
                                                           uint32_t seed);

} // namespace kindling
