// The kernels of the path tracer, each for one path or one pixel of a wave.
//
// The order of the paths does not matter: a path writes to its own slot alone, takes places in
// queues whose order is never read, and the sums of a pixel are exact.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/compact/queries.h"
#include "renderer/device/kernels/path_wave.h"
#include "renderer/device/kernels/wave_kernels.h"
#include "renderer/integrator/stages/prepare_path.h"
#include "renderer/integrator/stages/shade_path.h"

#include <cstdint>
#include <optional>

namespace kindling::kernels {

// Starts a path: its camera ray.
inline void begin_path(const PathWave& wave, uint32_t path) {
  wave.path_rays[path] = begin_sample(wave, path);
  wave.states[path] = PathState{};
  wave.active.paths[path] = path;
}

// Finds the nearest hit of the ray of an active path.
inline void intersect(const PathWave& wave, uint32_t number) {
  const uint32_t path = wave.active.paths[number];
  wave.hits[path] = wave.scene->world.probe_hit(wave.path_rays[path]);
}

// The same where WorldView::filters_hits is false. It needs far less of a GPU.
inline void intersect_opaque(const PathWave& wave, uint32_t number) {
  const uint32_t path = wave.active.paths[number];
  wave.hits[path] =
      accel::kd::compact::intersect(wave.scene->tree, wave.path_rays[path], accel::kd::compact::AcceptAll{});
}

// Takes the results of the stages of a path.
struct WaveSink {
  const PathWave& wave;

  void extend(const PathInFlight& path, const accel::Ray& ray) {
    wave.path_rays[path.slot] = ray;
    ++wave.rays[path.slot].bounces;
    wave.next.append(path.slot);
  }
  void add_shadow(const accel::Ray& ray, const ShadowRecord& record) {
    const uint32_t place = wave.shadows.take_place();
    wave.shadow_rays[place] = ray;
    wave.shadow_records[place] = record;
  }
  // Guides are trained, samples replayed and light groups and passes rendered on the CPU.
  static constexpr bool kSplits = false;
  static constexpr bool records() { return false; }
  void arrive(const PathInFlight& /*path*/, const SurfacePoint* /*surface*/) {}
  void reflect(const PathStages::Vertex& /*vertex*/, const GuidedBsdf::Sample& /*scattered*/,
               const PathInFlight& /*path*/) {}
  void offer_light(const PathStages::Vertex& /*vertex*/, const Rgb& /*contribution*/) {}
  void surface_event(const accel::Ray& /*ray*/, const accel::Hit& /*hit*/, const SurfacePoint& /*surface*/,
                     const PathState& /*state*/) {}
  void escaped_event(const accel::Ray& /*ray*/, const PathState& /*state*/) {}
  void scatter_event(const accel::Ray& /*ray*/, float /*distance*/, const V3f& /*position*/,
                     const PathState& /*state*/) {}
};

// Shades the hit of an active path, or what it sees beyond the scene.
inline void shade(const PathWave& wave, uint32_t launched) {
  const uint32_t number = number_of(wave.tiles, launched);
  const PathStages& stages = wave.scene->stages;
  const WorldView& world = wave.scene->world;
  const uint32_t slot = wave.active.paths[number];
  const accel::Ray ray = wave.path_rays[slot];
  const accel::Hit hit = wave.hits[slot];
  const PathInFlight path{slot, wave.samples[slot], wave.states[slot], wave.media[slot],
                          wave.surfaces != nullptr ? wave.surfaces + slot : nullptr};
  WaveSink sink{wave};
  if (!hit.is_hit()) {
    const EnvironmentView::Location at = world.lights.locate_in_environment(ray.direction);
    if (world.lights.has_shapes) stages.add_shapes(ray, hit, path);
    stages.shade_escaped(ray, at, path, sink);
    return;
  }
  SurfacePoint surface;
  const RayCone cone = path.state.cone;
  begin_look_ups(wave.tiles);
  world.surface_at(ray, hit, surface, stages.measure_footprint(ray, hit.t, path.state));
  if (waits_for_tiles(wave.tiles, number)) {
    path.state.cone = cone;
    return;
  }
  SurfaceDraws sampled;
  std::optional<LightSample> light;
  if (PathStages::reflects(surface, path.state)) {
    const BounceAddress address = PathStages::draws_address(path);
    sampled.draws = draw_bounce(address.address, address.dimension);
    const LightQuery query = stages.light_query(surface, ray.time, sampled);
    if (stages.samples_light(surface)) light = world.lights.sample(query);
  }
  if (world.lights.has_shapes) stages.add_shapes(ray, hit, path);
  stages.shade_hit(ray, hit, surface, sampled, light, path, sink);
}

// Traces a shadow ray, and adds its light to the path if nothing is in between.
inline void trace_shadow(const PathWave& wave, uint32_t number) {
  const DeviceScene& scene = *wave.scene;
  accel::Ray ray = wave.shadow_rays[number];
  ShadowRecord record = wave.shadow_records[number];
  uint32_t& rays = wave.rays[record.slot].shadows;
  ++rays;
  if (scene.world.probe_is_blocked(ray)) return;
  if (scene.world.has_thin_walls) {
    ray.flags = kHitThinWalls;
    SurfacePoint scratch;
    for (uint32_t thin_wall = 0;; ++thin_wall) {
      if (thin_wall == kMaxTransparentSurfaces) return; // behind too many thin walls
      const accel::Hit hit = scene.world.probe_hit(ray);
      ++rays;
      if (!hit.is_hit()) break;
      const PathStages::ThinWall wall = scene.stages.pass_thin_wall(hit, ray, scratch, record.contribution);
      if (wall == PathStages::ThinWall::blocks) return;
      if (wall == PathStages::ThinWall::last) break;
    }
  }
  PathStages::add_light(record, wave.states[record.slot]);
}

// The same where WorldView::filters_hits is false, so there are no thin walls either.
inline void trace_shadow_opaque(const PathWave& wave, uint32_t number) {
  const ShadowRecord& record = wave.shadow_records[number];
  ++wave.rays[record.slot].shadows;
  if (accel::kd::compact::occluded(wave.scene->tree, wave.shadow_rays[number], accel::kd::compact::AcceptAll{})) return;
  PathStages::add_light(record, wave.states[record.slot]);
}

// Adds the samples of a pixel to its sums.
inline void finish_pixel(const PathWave& wave, uint32_t pixel) {
  add_pixel(wave, pixel, [&](uint32_t slot) {
    PathState& state = wave.states[slot];
    const Rgb radiance = wave.scene->stages.radiance_of(state);
    return FinishedSample{radiance, state.alpha, state.light[kEmission], state.light[kDirect]};
  });
}

} // namespace kindling::kernels
