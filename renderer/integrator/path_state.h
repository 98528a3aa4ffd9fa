// The record of one path in flight, and the memory of one thread's batch of them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/ray_cone.h"
#include "renderer/integrator/camera_stage.h"
#include "renderer/integrator/integrator.h"
#include "renderer/integrator/medium_stack.h"
#include "renderer/integrator/shade_group.h"

#include <array>
#include <cstdint>
#include <vector>

namespace kindling {

class PathRecorder;

// Light that reached the camera, by how often it was reflected.
enum LightClass : uint32_t { kEmission = 0, kDirect = 1, kIndirect = 2 };

struct PathState {
  Rgb throughput{1.0f};
  float bsdf_pdf = 0.0f; // of the direction that the path's ray has; 0 after the camera and after delta directions
  std::array<Rgb, 3> light{Rgb(0.0f), Rgb(0.0f), Rgb(0.0f)}; // by LightClass
  V3f previous_position{0.0f};                               // where the ray started: what light sampling saw
  V3f previous_normal{0.0f};                                 // likewise
  const LightProbabilities* light_probabilities = nullptr;   // likewise
  // Of the ray: how much of the scene this sample stands for. Spread below 0: as the camera has it.
  RayCone cone{.spread = -1.0f};
  float alpha = 1.0f;
  float guiding = 1.0f;        // product over the reflections of density with guiding / density without
  float wavelength_nm = 0.0f;  // of a path that was dispersed; 0: all of them
  uint16_t bounce = 0;         // reflections and transmissions so far
  uint16_t scatter_events = 0; // inside of media, so far
  uint8_t diffuse_bounces = 0;
  uint8_t glossy_bounces = 0;
  uint8_t transmission_bounces = 0;
  bool emission_only = false;       // a bounce limit is reached: the next hit may only emit
  uint8_t transparent_surfaces = 0; // passed since the last reflection
  WidestLobe widest_lobe;           // of the reflections so far; only with Caustics::regularized
  bool in_medium = false;           // PathContext::media of the slot is not empty; else it is not up to date

  // Of the sampler; `relative` to the bounce.
  [[nodiscard]] uint32_t dimension(uint32_t relative) const {
    return kFirstBounceDimension + bounce * kBounceDimensions + relative;
  }
  // The class of light that is found by a ray after `bounce` reflections.
  [[nodiscard]] uint32_t light_class(uint32_t reflections) const { return std::min<uint32_t>(reflections, kIndirect); }
};
static_assert(sizeof(PathState) == 120);

// More than this many partly transparent surfaces in a row absorb what is left of a path or of a shadow ray.
inline constexpr uint32_t kMaxTransparentSurfaces = 128;

// A light sample that waits for its shadow ray.
struct ShadowRecord {
  Rgb contribution;  // added to the path if nothing is in between
  uint32_t slot = 0; // of the path
  uint32_t light_class = kDirect;
};

// One thread's batch. A path keeps its slot for life; `active` lists the living ones, and rays and hits run parallel to it.
// Sized once, never grown: nothing allocates per sample.
class PathContext final : public ThreadContext {
 public:
  explicit PathContext(size_t batch_size, bool with_surfaces)
      : camera_samples(batch_size), states(batch_size), media(batch_size), surfaces(with_surfaces ? batch_size : 0),
        active(batch_size), next_active(batch_size), rays(batch_size), next_rays(batch_size), hits(batch_size),
        shadow_rays(batch_size), shadow_records(batch_size), occluded(batch_size), thin_wall_rays(batch_size),
        thin_wall_hits(batch_size), thin_wall_records(batch_size) {}

  std::vector<CameraSample> camera_samples; // by slot
  std::vector<PathState> states;            // by slot
  std::vector<MediumStack> media;           // by slot; only where the state is in_medium
  std::vector<FilmSurface> surfaces;        // by slot; empty if no AOV needs it
  std::vector<uint32_t> active, next_active;
  std::vector<accel::Ray> rays, next_rays;
  std::vector<accel::Hit> hits;
  std::vector<accel::Ray> shadow_rays;
  std::vector<ShadowRecord> shadow_records;
  std::vector<uint8_t> occluded;
  // Shadow rays that go from thin wall to thin wall.
  std::vector<accel::Ray> thin_wall_rays;
  std::vector<accel::Hit> thin_wall_hits;
  std::vector<uint32_t> thin_wall_records; // number of the shadow ray
  PathRecorder* recorder = nullptr;        // set while a guide is trained
  ShadeGroup group;
};

} // namespace kindling
