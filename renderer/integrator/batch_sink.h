// Takes the results of a path's stages into its batch, for the training of a guide and for replays.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/append_reserved.h"
#include "renderer/integrator/manifolds/manifold_light.h"
#include "renderer/integrator/path_context.h"
#include "renderer/integrator/path_recorder.h"
#include "renderer/integrator/path_reuse.h"
#include "renderer/integrator/path_trace.h"
#include "renderer/integrator/stages/gather_photons.h"
#include "renderer/world/world.h"

namespace kindling {

// A sink of PathStages.
struct BatchSink {
  static constexpr bool kSplits = false;
  static constexpr bool kBesideLightPaths = true;
  static constexpr bool kManifolds = true;
  static constexpr bool kReuses = true;

  PathContext& context;
  const World& world; // for the names of materials
  const PathStages& path_stages;

  void extend(const PathInFlight& path, const accel::Ray& ray) {
    append_reserved(context.next_active, path.slot);
    append_reserved(context.next_rays, ray);
  }
  void add_shadow(const accel::Ray& ray, const ShadowRecord& record) {
    append_reserved(context.shadow_rays, ray);
    append_reserved(context.shadow_records, record);
  }

  void gather_photons(const PathStages::Vertex& vertex, const PathInFlight& path, float radius2) {
    if (context.photon_maps.empty()) return;
    const PhotonMapView map = context.photon_maps.of_sample(path.map_sample).view();
    if (context.gathered)
      path.state.light[kIndirect] +=
          gathered_light(path_stages, map, vertex, path, radius2, [&](const Photon& photon, const Rgb& part) {
            context.gathered->push_back(note_gathered(vertex, path, photon, part));
          });
    else
      path.state.light[kIndirect] += gathered_light(path_stages, map, vertex, path, radius2);
  }

  void add_manifold_light(const PathInFlight& path, const ManifoldLight& found) {
    path.state.light[kIndirect] += found.light;
    context.counters.bounce += found.rays;
  }

  [[nodiscard]] ReusedPath* reused(const PathInFlight& path) const {
    return context.reuses() ? &context.reuse->paths[path.slot] : nullptr;
  }
  [[nodiscard]] bool records() const { return context.recorder != nullptr; }
  void arrive(const PathInFlight& path, const SurfacePoint* surface) {
    if (context.recorder) context.recorder->arrive(path.slot, path.state, surface);
  }
  void escape(const PathInFlight& path, const accel::Ray& ray) {
    if (context.recorder) context.recorder->escape(path.slot, path.state, ray.direction, world.bounds);
  }
  void reflect(const PathStages::Vertex& vertex, const GuidedBsdf::Sample& scattered, const PathInFlight& path) {
    if (!context.recorder) return;
    GuideRecord record;
    record.position = vertex.surface.position;
    record.normal = vertex.surface.shading_normal;
    record.base = scattered.bsdf_pdf / scattered.pdf;
    record.replaced = vertex.bsdf.replaceable(scattered.bsdf_pdf, scattered.cosine) / scattered.pdf;
    record.allowed = vertex.bsdf.allowed() / scattered.pdf;
    if (scattered.cosine > 0.0f) record.environment = record.allowed * world.lights.environment.pdf(scattered.wi);
    record.without_caustics = vertex.bsdf.without_caustics(scattered) / scattered.pdf;
    context.recorder->reflect(path.slot, record);
  }
  void offer_light(const PathStages::Vertex& vertex, const LightSample& light, const Rgb& contribution) {
    if (!context.recorder) return;
    const SurfacePoint& surface = vertex.surface;
    const float unguided = world.lights.unlearned_kind_probability(surface.position, surface.light_normal(), light);
    context.recorder->offer_light({.position = surface.position,
                                   .facing = static_cast<uint8_t>(facing_of(surface.geometric_normal)),
                                   .kind = light.kind,
                                   .moment = square(luminance(contribution)) * light.kind_probability,
                                   .unguided_probability = unguided > 0.0f ? unguided : light.kind_probability});
  }

  void surface_event(const accel::Ray& ray, const accel::Hit& hit, const SurfacePoint& surface,
                     const PathState& state) {
    if (is_traced(state)) trace_surface(context, ray, hit, surface, world, state);
  }
  void escaped_event(const accel::Ray& ray, const PathState& state) {
    if (!is_traced(state)) return;
    trace_event(context, [&](PathVertex& vertex) {
      vertex.event = "escaped";
      vertex.bounce = state.bounce;
      vertex.direction = ray.direction;
      vertex.throughput = state.throughput;
      vertex.radiance = state.light[0] + state.light[1] + state.light[2];
      vertex.bounces = bounces_of(state);
    });
  }
  void scatter_event(const accel::Ray& ray, float distance, const V3f& position, const PathState& state) {
    if (!is_traced(state)) return;
    trace_event(context, [&](PathVertex& vertex) {
      vertex.event = "scattered in a medium";
      vertex.bounce = state.bounce;
      vertex.position = position;
      vertex.direction = ray.direction;
      vertex.distance = distance;
      vertex.throughput = state.throughput;
      vertex.bounces = bounces_of(state);
    });
  }

 private:
  [[nodiscard]] bool is_traced(const PathState& state) const {
    return context.trace && &state == &context.states[context.traced_slot];
  }
};

} // namespace kindling
