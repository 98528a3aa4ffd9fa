// A sink that also splits the light of paths by light group and by first event.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/batch_sink.h"
#include "renderer/world/light_groups.h"

#include <algorithm>

namespace kindling {

struct SplittingSink : BatchSink {
  static constexpr bool kSplits = true;
  static constexpr bool kBesideLightPaths = true;
  const LightGroups& groups;

  [[nodiscard]] SplitLight& split_light() const { return *context.split_light; }

  // The first event of a path is that of its first surface: the light that it brings is split
  // like the BSDF's value for the direction that the path takes there.
  void first_surface(const PathStages::Vertex& vertex, const PathInFlight& path) const {
    if (path.state.bounce != 0) return;
    const LobeAlbedos albedos = vertex.bsdf.bsdf().lobe_albedos();
    split_light().colors[path.slot] = {albedos.diffuse, albedos.glossy, albedos.transmission};
  }
  void scatter_first(const PathStages::Vertex& vertex, const GuidedBsdf::Sample& scattered,
                     const PathInFlight& path) const {
    if (path.state.bounce != 0) return;
    split_light().firsts[path.slot] = scattered.pdf > 0.0f || scattered.cosine < 0.0f
                                          ? event_at(vertex, scattered.wi, scattered.cosine < 0.0f)
                                          : FirstEvent{FirstEvent::Kind::reflection, Rgb(0.0f)}; // a mirror
  }
  // A medium that the path has entered at its first surface.
  void scatter_event(const accel::Ray& ray, float distance, const V3f& position, const PathState& state) {
    BatchSink::scatter_event(ray, distance, position, state);
    FirstEvent& first = split_light().firsts[static_cast<size_t>(&state - context.states.data())];
    if (state.scatter_events == 1 && state.bounce <= 1 && first.kind != FirstEvent::Kind::reflection)
      first = {FirstEvent::Kind::volume, Rgb(0.0f)};
  }

  void offer_light(const PathStages::Vertex& vertex, const LightSample& light, const Rgb& contribution) {
    BatchSink::offer_light(vertex, light, contribution);
    const bool beyond = light.wi.dot(vertex.frame.normal) < 0.0f;
    split_light().shadows.push_back(
        {groups.names.empty() ? uint8_t{0} : groups.of(light), event_at(vertex, light.wi, beyond)});
  }

  // Light that photons bring to the first surface has its first event there.
  void gather_photons(const PathStages::Vertex& vertex, const PathInFlight& path, float radius2) const {
    if (context.photon_maps.empty()) return;
    const PhotonMapView map = context.photon_maps.of_sample(path.map_sample).view();
    const auto split = [&](const Photon& photon, const Rgb& part) {
      const FirstEvent first = path.state.bounce > 0
                                   ? split_light().firsts[path.slot]
                                   : event_at(vertex, photon.to_light, photon.to_light.dot(vertex.frame.normal) < 0.0f);
      split_light().add(path.slot, photon.group, kIndirect, first, LightPass::emit, part);
    };
    path.state.light[kIndirect] += gathered_light(path_stages, map, vertex, path, radius2, split);
  }

  void split_emission(const PathInFlight& path, const accel::Hit& hit, const SurfacePoint& surface,
                      const Rgb& light) const {
    const uint8_t group = groups.names.empty() ? uint8_t{0} : groups.of_surface(world.node_of(hit), surface.material);
    add(path, group, LightPass::emit, light);
  }
  void split_environment(const PathInFlight& path, const Rgb& light) const {
    add(path, groups.environment, LightPass::environment, light);
  }
  void split_shapes(const PathStages& stages, const accel::Ray& ray, const accel::Hit& hit,
                    const PathInFlight& path) const {
    if (path.state.bounce == 0) return; // not seen by the camera
    const auto first_punctual = world.lights.triangles.size();
    world.lights.visit_shapes(stages.shape_ray(ray, hit, path), [&](uint32_t number, const Rgb& radiance) {
      const uint8_t group = groups.names.empty() ? uint8_t{0} : groups.of_emitter[first_punctual + number];
      add(path, group, LightPass::emit,
          path.state.throughput * radiance * stages.shape_weight(ray, number, path.state));
    });
  }

 private:
  void add(const PathInFlight& path, uint8_t group, LightPass seen, const Rgb& light) const {
    const PathState& state = path.state;
    split_light().add(path.slot, group, state.light_class(state.bounce), split_light().firsts[path.slot], seen, light);
  }
  static FirstEvent event_at(const PathStages::Vertex& vertex, const V3f& wi, bool beyond) {
    return event_towards(vertex.bsdf.bsdf(), vertex.frame.to_local(wi), beyond);
  }
};

} // namespace kindling
