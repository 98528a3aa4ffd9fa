// The kernels of the path tracer, each for one path or one pixel of a wave.
//
// The order of the paths does not matter: a path writes to its own slot alone, takes places in
// queues whose order is never read, and the sums of a pixel are exact.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/compact/queries.h"
#include "renderer/device/kernels/path_wave.h"
#include "renderer/device/kernels/wave_kernels.h"
#include "renderer/integrator/stages/gather_photons.h"
#include "renderer/integrator/stages/light_draws.h"
#include "renderer/integrator/stages/prepare_path.h"
#include "renderer/integrator/stages/shade_path.h"
#include "renderer/integrator/stages/trace_shadow.h"

#include <cstdint>
#include <optional>

namespace kindling::kernels {

// Starts a path: its camera ray.
inline void begin_path(const PathWave& wave, uint32_t path) {
  wave.path_rays[path] = begin_sample(wave, path);
  wave.states[path] = PathState{};
  if (wave.reuse.paths != nullptr) wave.reuse.paths[path].start();
  wave.active.paths[path] = path;
}

// Sets the hit of an active path, and counts its kind.
inline void arrive_at(const PathWave& wave, uint32_t number, uint32_t path, const accel::Hit& hit) {
  wave.hits[path] = hit;
  if (wave.kinds == nullptr) return;
  const WorldView& world = wave.scene->world;
  const uint32_t kind = hit.is_hit() ? 1 + world.geometries[hit.mesh].material % (kHitKinds - 1) : 0;
  wave.kinds[number] = static_cast<uint8_t>(kind);
  (void)take_places(wave.kind_counts[kind], 1, kind);
}

// Finds the nearest hit of the ray of an active path.
inline void intersect(const PathWave& wave, uint32_t number) {
  const uint32_t path = wave.active.paths[number];
  arrive_at(wave, number, path, wave.scene->world.probe_hit(wave.path_rays[path]));
}

// The same where WorldView::filters_hits is false. It needs far less of a GPU.
inline void intersect_opaque(const PathWave& wave, uint32_t number) {
  const uint32_t path = wave.active.paths[number];
  arrive_at(wave, number, path,
            accel::kd::compact::intersect(wave.scene->tree, wave.path_rays[path], accel::kd::compact::AcceptAll{}));
}

// By kind: finds the first place of its paths.
inline void place_kinds(const PathWave& wave, uint32_t kind) {
  uint32_t first = 0;
  for (uint32_t other = 0; other < kind; ++other) first += wave.kind_counts[other];
  wave.kind_places[kind] = first;
}

// Moves an active path to those of its kind, which take the same branches of shade() and read the
// same material. Their order is any.
inline void sort_paths(const PathWave& wave, uint32_t number) {
  const uint32_t kind = wave.kinds[number];
  wave.sorted_paths[take_places(wave.kind_places[kind], 1, kind)] = wave.active.paths[number];
}

// Other ways to find light beside paths from the camera.
enum class Beside : uint8_t { nothing, light_paths, photons, manifolds };

// Takes the results of the stages of a path. Photons may be beside light paths. `kReuse`: paths are
// shared between pixels.
template <Beside kBeside, bool kReuse>
struct WaveSink {
  static constexpr bool kManifolds = kBeside == Beside::manifolds;
  static constexpr bool kBesideLightPaths = kBeside == Beside::light_paths || kBeside == Beside::photons;

  const PathWave& wave;
  uint32_t max_shadow_rays = 1; // that this surface adds
  uint32_t first_shadow = 0, shadow_count = 0;

  [[nodiscard]] static WaveSink of(const PathWave& wave) { return {wave}; }
  void extend(const PathInFlight& path, const accel::Ray& ray) {
    wave.path_rays[path.slot] = ray;
    ++wave.rays[path.slot].bounces;
    wave.next.append(path.slot);
  }
  void add_shadow(const accel::Ray& ray, const ShadowRecord& record) {
    if (shadow_count == 0) {
      first_shadow = wave.shadows.take_places(max_shadow_rays);
      for (uint32_t i = 1; i < max_shadow_rays; ++i) {
        wave.shadow_records[first_shadow + i].count = 0;
        wave.shadow_records[first_shadow + i].is_ray = false;
      }
    }
    const uint32_t place = first_shadow + shadow_count;
    wave.shadow_rays[place] = ray;
    wave.shadow_records[place].record = record;
    wave.shadow_records[place].is_ray = true;
    wave.shadow_records[first_shadow].count = ++shadow_count;
  }
  void gather_photons(const PathStages::Vertex& vertex, const PathInFlight& path, float radius2) {
    if constexpr (kBeside == Beside::photons)
      path.state.light[kIndirect] +=
          gathered_light(wave.scene->stages, wave.photons.of_sample(path.map_sample), vertex, path, radius2);
  }
  void add_manifold_light(const PathInFlight& path, const ManifoldLight& found) {
    path.state.light[kIndirect] += found.light;
    wave.rays[path.slot].bounces += found.rays;
  }
  static constexpr bool kSplits = false;
  static constexpr bool kReuses = kReuse;
  [[nodiscard]] ReusedPath* reused(const PathInFlight& path) const {
    return wave.reuse.paths != nullptr ? wave.reuse.paths + path.slot : nullptr;
  }
  // Guides are trained, and samples replayed, on the CPU.
  static constexpr bool records() { return false; }
  void arrive(const PathInFlight& /*path*/, const SurfacePoint* /*surface*/) {}
  void escape(const PathInFlight& /*path*/, const accel::Ray& /*ray*/) {}
  void reflect(const PathStages::Vertex& /*vertex*/, const GuidedBsdf::Sample& /*scattered*/,
               const PathInFlight& /*path*/) {}
  void offer_light(const PathStages::Vertex& /*vertex*/, const LightSample& /*light*/, const Rgb& /*contribution*/) {}
  void surface_event(const accel::Ray& /*ray*/, const accel::Hit& /*hit*/, const SurfacePoint& /*surface*/,
                     const PathState& /*state*/) {}
  void escaped_event(const accel::Ray& /*ray*/, const PathState& /*state*/) {}
  void scatter_event(const accel::Ray& /*ray*/, float /*distance*/, const V3f& /*position*/,
                     const PathState& /*state*/) {}
};

// The light samples of a path at a surface, one after the other: an array of them would be in local
// memory.
struct LightsInTurn {
  const PathWave& wave;
  const PathInFlight& path;
  const LightQuery& query;
  uint32_t count; // 0: none are sampled

  [[nodiscard]] uint32_t size() const { return count; }
  [[nodiscard]] std::optional<LightSample> operator[](uint32_t number) const {
    const LightSetView& lights = wave.scene->world.lights;
    if (count == 1) return lights.sample(query);
    const BounceAddress address = PathStages::draws_address(path);
    const BounceDraws draws = draw_bounce(light_sample_address(address.address, number, count), address.dimension);
    return lights.sample(PathStages::light_query(query, {draws.light, draws.spare}));
  }
};

template <typename Sink>
inline void shade_path(const PathWave& wave, uint32_t launched) {
  const uint32_t number = number_of(wave.tiles, launched);
  const PathStages& stages = wave.scene->stages;
  const WorldView& world = wave.scene->world;
  const uint32_t slot = wave.active.paths[number];
  const accel::Ray ray = wave.path_rays[slot];
  const accel::Hit hit = wave.hits[slot];
  const PathInFlight path{slot,
                          wave.samples[slot],
                          wave.states[slot],
                          wave.media[slot],
                          wave.surfaces != nullptr ? wave.surfaces + slot : nullptr,
                          wave.pixels.empty() ? wave.samples[slot].sample_index : wave.photons.level};
  Sink sink = Sink::of(wave);
  const auto add_shapes = [&] {
    if (!world.lights.has_shapes) return;
    stages.add_shapes(ray, hit, path, sink);
    if constexpr (Sink::kSplits) sink.split_shapes(stages, ray, hit, path);
  };
  if (!hit.is_hit()) {
    const EnvironmentView::Location at = world.lights.locate_in_environment(ray.direction);
    add_shapes();
    stages.shade_escaped(ray, at, path, sink);
    return;
  }
  if (const std::optional<float> distance = stages.scatter_distance(hit.t, path)) {
    (void)stages.measure_footprint(ray, *distance, path.state);
    add_shapes();
    stages.scatter_in_medium(ray, *distance, path, sink);
    return;
  }
  SurfacePoint surface;
  const RayCone cone = path.state.cone, specular_cone = path.state.specular_cone;
  begin_look_ups(wave.tiles);
  world.surface_at(ray, hit, surface, stages.measure_footprint(ray, hit.t, path.state));
  if (waits_for_tiles(wave.tiles, number)) {
    path.state.cone = cone;
    path.state.specular_cone = specular_cone;
    return;
  }
  SurfaceDraws sampled;
  LightQuery query;
  LightsInTurn lights{wave, path, query, 0};
  if (PathStages::reflects(surface, path.state)) {
    const BounceAddress address = PathStages::draws_address(path);
    sampled.draws = draw_bounce(address.address, address.dimension);
    sampled.light_probabilities = stages.learned_probabilities(surface);
    query = stages.light_query(surface, ray.time, sampled, path);
    if (stages.samples_light(surface)) {
      lights.count = stages.light_sample_count(path.state);
      sink.max_shadow_rays = stages.max_shadow_rays(path.state);
    }
  }
  add_shapes();
  stages.shade_hit(ray, hit, surface, sampled, lights, path, sink);
  if (wave.first_hits != nullptr && path.surface->hit && !wave.first_hits[slot].hit.is_hit())
    wave.first_hits[slot].hit = hit;
}

// Shades the hit of an active path, or what it sees beyond the scene.
inline void shade(const PathWave& wave, uint32_t number) { shade_path<WaveSink<Beside::nothing, false>>(wave, number); }
// The same beside light paths, whose weights take more of a GPU, with photons, and with manifold
// sampling.
inline void shade_beside_light_paths(const PathWave& wave, uint32_t number) {
  shade_path<WaveSink<Beside::light_paths, false>>(wave, number);
}
inline void shade_beside_photons(const PathWave& wave, uint32_t number) {
  shade_path<WaveSink<Beside::photons, false>>(wave, number);
}
inline void shade_with_manifolds(const PathWave& wave, uint32_t number) {
  shade_path<WaveSink<Beside::manifolds, false>>(wave, number);
}
// The same where paths are shared between pixels.
inline void shade_reused(const PathWave& wave, uint32_t number) {
  shade_path<WaveSink<Beside::nothing, true>>(wave, number);
}

// Adds the light of a shadow ray to its path, if it is visible, and leaves it for split_shadow().
inline void add_light(const PathWave& wave, uint32_t number, const ShadowRecord& record, bool visible) {
  if (wave.split.by_pass != nullptr)
    wave.shadow_records[number].record.contribution = visible ? record.contribution : Rgb(0.0f);
  if (!visible) return;
  if (record.light_class == kReusedLight)
    wave.reuse.paths[record.slot].light = record.contribution;
  else
    PathStages::add_light(record, wave.states[record.slot]);
}

// Traces the shadow rays of a path, if the first one has this number.
inline void trace_shadow(const PathWave& wave, uint32_t number) {
  const uint32_t count = wave.shadow_records[number].count;
  for (uint32_t i = number; i < number + count; ++i) {
    ShadowRecord record = wave.shadow_records[i].record;
    const bool visible =
        reaches_light(wave.scene->stages, wave.shadow_rays[i], record.contribution, wave.rays[record.slot].shadows);
    add_light(wave, i, record, visible);
  }
}

// Traces one shadow ray, where WorldView::filters_hits is false, so there are no thin walls either.
// Where its path has several, add_shadows() adds their light.
inline void trace_shadow_opaque(const PathWave& wave, uint32_t number) {
  WaveShadow& shadow = wave.shadow_records[number];
  if (!shadow.is_ray) return;
  const bool visible =
      !accel::kd::compact::occluded(wave.scene->tree, wave.shadow_rays[number], accel::kd::compact::AcceptAll{});
  if (shadow.count != 1) {
    shadow.visible = visible;
    return;
  }
  ++wave.rays[shadow.record.slot].shadows;
  add_light(wave, number, shadow.record, visible);
}

// Adds the light of the shadow rays of a path that has several, if the first one has this number.
inline void add_shadows(const PathWave& wave, uint32_t number) {
  const uint32_t count = wave.shadow_records[number].count;
  if (count < 2) return;
  wave.rays[wave.shadow_records[number].record.slot].shadows += count;
  for (uint32_t i = number; i < number + count; ++i)
    add_light(wave, i, wave.shadow_records[i].record, wave.shadow_records[i].visible);
}

// Returns the function that add_pixel() asks for a path's light.
[[nodiscard]] inline auto finished_path(const PathWave& wave) {
  return [&wave](uint32_t slot) {
    PathState& state = wave.states[slot];
    const Rgb radiance = wave.scene->stages.radiance_of(state);
    return FinishedSample{radiance, state.alpha, state.light[kEmission], state.light[kDirect]};
  };
}

// Adds the samples of a pixel to its sums.
inline void finish_pixel(const PathWave& wave, uint32_t pixel) { add_pixel(wave, pixel, finished_path(wave)); }

} // namespace kindling::kernels
