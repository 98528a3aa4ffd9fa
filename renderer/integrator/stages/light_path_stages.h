// The stages of a light path, each for one path at a time: the same code on every device.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/ray.h"
#include "renderer/film/split_light.h"
#include "renderer/integrator/stages/light_path_view.h"
#include "renderer/integrator/stages/outside_pixels.h"
#include "renderer/integrator/stages/path_stages.h"
#include "renderer/integrator/stages/photon_view.h"
#include "renderer/light/emission_view.h"
#include "renderer/sampling/sample_range.h"
#include "renderer/world/light_groups/light_groups_view.h"

#include <cmath>
#include <cstdint>
#include <optional>

namespace kindling {

// A path on its way from the light.
struct LightPathState {
  EmittedRay emitted;
  Rgb throughput{1.0f};            // before the first caster, that of thin walls alone
  float first_throughput = 0.0f;   // its largest component at the first caster
  uint32_t key = 0, index = 0;     // of its random numbers
  uint32_t material = 0;           // of the medium around it, if in_medium
  float wavelength_nm = 0.0f;      // from a refraction at dispersive glass on; 0: all
  float narrow_probability = 1.0f; // that the first caster scatters narrowly
  float first_pdf = 0.0f;          // density of the direction that it chose; 0: a delta direction
  bool in_medium = false;
  bool reflected_undispersed = false; // off the outside of dispersive glass
  uint8_t bounces = 0;
  uint8_t thin_walls = 0; // passed since the last bounce
  // Bounces behind the first caster, by lobe, for the limits: these count from the camera.
  uint8_t diffuse_bounces = 0, glossy_bounces = 0, transmission_bounces = 0;
};

// A surface of a light path that is joined to the camera: light that a ray of the camera finds
// unless something is in between.
struct LightJoint {
  V2f film_px;
  Rgb radiance;       // times square pixels
  V3f direction;      // from the camera, unit
  float scale = 0.0f; // LightPathView::ratio_scale()
  float ratio = 0.0f; // of the densities of light paths and paths from the camera, for the weight
  accel::Ray sight;   // of the camera
};

// Everything that light paths read beside PathStages, which are those of the camera's paths. A path
// goes from one ray to the next:
//
//   start()                  the ray of a light
//   WorldView::surface_at    the surface at its hit; paths without a hit end
//   scatter()                the joint with the camera, and the next ray
//   visit_splat_pixels()     the pixels of a joint whose sight is free (splat_pixels.h)
//
// Paths that leave photons have numbers from kFirstPhotonPath on, and scatter_photon() in place of
// scatter().
struct LightPathStages : LightPathView {
  static constexpr uint64_t kFirstPhotonPath = uint64_t{1} << 62; // no sample has a light path of these numbers

  // Starts the path of a number; false if it carries no light.
  [[nodiscard]] bool start(uint64_t number, LightPathState& path, accel::Ray& ray) const;
  // Returns the number of the path that a pixel has in a pass (light_path_passes()).
  [[nodiscard]] uint64_t number_of(const V2i& pixel, uint32_t pass) const {
    const auto width = static_cast<uint64_t>(camera->size_px().x);
    return number_at(static_cast<uint64_t>(pixel.y) * width + static_cast<uint64_t>(pixel.x), pass);
  }
  // The same for a pixel by its index, row by row.
  [[nodiscard]] uint64_t number_at(uint64_t pixel, uint32_t pass) const {
    const V2i size = camera->size_px();
    return pass * (static_cast<uint64_t>(size.x) * static_cast<uint64_t>(size.y)) + pixel;
  }
  // Moves a path on from its hit, where it has the surface as its ray sees it. True if it continues
  // with the ray that replaces `ray`. Sets `joint` if the surface is joined to the camera.
  [[nodiscard]] bool scatter(const PathStages& paths, const accel::Hit& hit, SurfacePoint& surface, accel::Ray& ray,
                             LightPathState& path, std::optional<LightJoint>& joint) const;
  // The same for a path that leaves photons and is not joined to the camera: sets `photon` if it
  // leaves one at the surface. `groups`: of its light.
  [[nodiscard]] bool scatter_photon(const PathStages& paths, const LightGroupsView& groups, const accel::Hit& hit,
                                    SurfacePoint& surface, accel::Ray& ray, LightPathState& path,
                                    std::optional<Photon>& photon) const;

  // Steps of scatter().
  //
  // The way in which a path continues from a surface. Where it `joins`, it scatters, and paths
  // from the camera may be joined to it.
  enum class Arrival : uint8_t { ends, passes_straight, scatters, joins };
  // Applies the medium up to the surface and, at the first caster, the radiance of the light.
  [[nodiscard]] Arrival arrive(const accel::Hit& hit, const SurfacePoint& surface, LightPathState& path) const;
  [[nodiscard]] static bool pass_straight(const PathStages& paths, SurfacePoint& surface, accel::Ray& ray,
                                          LightPathState& path);
  [[nodiscard]] bool bounce(const PathStages& paths, SurfacePoint& surface, const accel::Hit& hit, accel::Ray& ray,
                            LightPathState& path) const;
  // Gives a path that is refracted at dispersive glass its wavelength. False: such paths are left
  // to the camera's.
  [[nodiscard]] bool take_color(uint32_t material, bool crosses, const PathStages::LayersHere& layers,
                                LightPathState& path) const;
  // Returns the group of the light that a path comes from; 0 if there are none.
  [[nodiscard]] uint8_t group_of(const LightGroupsView& groups, const LightPathState& path) const {
    if (groups.count == 0) return 0;
    const uint32_t emitter = path.emitted.emitter;
    return emitter == emission.environment_emitter() ? groups.environment : groups.of_emitter[emitter];
  }
  // Returns the parts of the light that light from a joint belongs to, as SplitSink splits the
  // light of paths from the camera. Surface, hit and ray are those at the joint.
  [[nodiscard]] SplatParts parts_of(const PathStages& paths, const LightGroupsView& groups, const SurfacePoint& surface,
                                    const accel::Hit& hit, const accel::Ray& ray, const LightPathState& path,
                                    const LightJoint& joint) const;
  void join_camera(const PathStages& paths, const SurfacePoint& surface, const accel::Hit& hit, const accel::Ray& ray,
                   const LightPathState& path, std::optional<LightJoint>& joint) const;

  const WorldView* world = nullptr;
  const CameraView* camera = nullptr;
  float filter_width = 0.0f; // of the pixel filter
  OutsidePixels outside;     // of the crop; surfaces are joined to the camera where its pixels show them
  uint32_t seed = 0;
};

// Returns the passes of light paths that begin with these samples of a pixel, a fraction of them,
// evenly: in each of its passes a pixel has one light path.
[[nodiscard]] inline SampleRange light_path_passes(float fraction, const SampleRange& samples) {
  const auto before = [fraction](uint32_t sample) {
    return static_cast<uint32_t>(std::ceil(static_cast<double>(fraction) * static_cast<double>(sample)));
  };
  return {before(samples.first), before(samples.end)};
}

} // namespace kindling
