// Light paths: from lights over mirrors and glass to surfaces, joined to the camera there.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/film.h"
#include "renderer/integrator/integrator_settings.h"
#include "renderer/integrator/stages/medium_stack.h"
#include "renderer/integrator/stages/path_stages.h"
#include "renderer/light/emission_sampling.h"
#include "renderer/sampling/pixel_filter.h"
#include "renderer/sampling/sample_range.h"
#include "renderer/world/world.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace kindling {

struct RayCounters;

// One thread's light paths of a batch.
struct LightPathContext {
  // A path on its way from the light. Reflections are listed for the bounce limits, which count
  // from the camera.
  struct Path {
    EmittedRay emitted;
    Rgb throughput{1.0f};          // before the first caster, that of thin walls alone
    float first_throughput = 0.0f; // its largest component at the first caster
    float arriving = 0.0f;         // density of light paths there, per square meter; only if measured
    uint32_t key = 0, index = 0;   // of its random numbers
    uint32_t material = 0;         // of the medium around it, if in_medium
    bool in_medium = false;
    bool reflected_undispersed = false; // off the outside of dispersive glass
    float wavelength_nm = 0.0f;         // from a refraction at such glass on; 0: all
    float narrow_probability = 1.0f;    // that the first caster scatters narrowly
    uint8_t bounces = 0;
    uint8_t thin_walls = 0; // passed since the last bounce
    struct Bounce {
      Lobe lobe;
      float pdf;
    };
    std::array<Bounce, LightPathView::kMaxBounces> lobes{};
  };
  // Light that a ray from the camera finds unless something is in between.
  struct Splat {
    V2f film_px;
    Rgb radiance;              // times square pixels
    float ratio = 0.0f;        // of the densities of light paths and paths from the camera, for the weight
    float traced_ratio = 0.0f; // the same for paths as they are traced; only if measured
  };

  std::vector<Path> paths;
  std::vector<uint32_t> active; // indices of paths, parallel to rays
  std::vector<accel::Ray> rays;
  std::vector<accel::Hit> hits;
  std::vector<Splat> splats; // parallel to camera_rays
  std::vector<accel::Ray> camera_rays;
  std::vector<uint8_t> occluded;
  std::vector<Splat> found; // of all paths
  uint64_t path_count = 0;
  bool measures = false; // finds Splat::traced_ratio, for a pilot
};

// Traces light paths in addition to those from the camera (Arvo 1986, "Backward Ray Tracing"; Veach
// 1997, section 8.3): light that lamps and suns throw through glass and off metal onto other
// surfaces, as the camera sees it directly. Paths belong to samples of pixels, whichever pixels
// they reach, so that any division of the samples gives the same sums.
class LightPaths : public LightPathView {
 public:
  // The stages, the camera and the world must outlive this.
  LightPaths(const IntegratorSettings& settings, const World& world, const Camera& camera, const PixelFilter& filter,
             uint32_t seed);

  // False if no light reaches a caster: there is nothing to trace.
  [[nodiscard]] bool useful() const { return !emission.empty(); }
  // Traces the light paths of these samples; then add_to() adds what they found to the film.
  // `stages` are those of the camera's paths.
  void trace(const PathStages& stages, const PixelRect& block, const SampleRange& samples, LightPathContext& context,
             RayCounters& counters) const;
  void add_to(const PixelRect& block, const LightPathContext& context, Film& film) const;
  // Traces light paths by their numbers, which belong to no samples.
  void trace_numbers(const PathStages& stages, uint64_t first, uint64_t count, LightPathContext& context,
                     RayCounters& counters) const;

 private:
  static void clear(LightPathContext& context);
  void start(const PixelRect& block, uint32_t pass, LightPathContext& context) const;
  void start_path(uint64_t number, LightPathContext& context) const;
  void follow(const PathStages& stages, LightPathContext& context, RayCounters& counters) const;
  // Moves a path on from its hit. True if it continues with the ray that replaces `ray`.
  bool scatter(const PathStages& stages, const accel::Hit& hit, accel::Ray& ray, LightPathContext::Path& path,
               LightPathContext& context) const;
  bool pass_straight(const PathStages& stages, SurfacePoint& surface, accel::Ray& ray,
                     LightPathContext::Path& path) const;
  bool bounce(const PathStages& stages, SurfacePoint& surface, const accel::Hit& hit, accel::Ray& ray,
              LightPathContext::Path& path) const;
  bool take_color(uint32_t material, bool crosses, const PathStages::LayersHere& layers,
                  LightPathContext::Path& path) const;
  [[nodiscard]] float arriving_density(const EmittedRay& emitted, const V3f& at) const;
  void join_camera(const PathStages& stages, const SurfacePoint& surface, const accel::Hit& hit, const accel::Ray& ray,
                   const LightPathContext::Path& path, LightPathContext& context) const;
  void keep_visible(LightPathContext& context, RayCounters& counters) const;

  const World& world_;
  const Camera& camera_;
  PixelFilter filter_;
  std::optional<EmissionSampling> sampling_;
  std::vector<uint8_t> caster_flags_;
  uint32_t seed_;
  float fraction_; // of the samples that have a light path
};

// Returns the light path pass that begins with this sample of a pixel, if one does: a fraction of
// the samples, evenly.
[[nodiscard]] std::optional<uint32_t> light_path_pass(float fraction, uint32_t sample);

} // namespace kindling
