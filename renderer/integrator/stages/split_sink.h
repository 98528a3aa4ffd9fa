// Sinks that also split the light of paths by light group and by first event.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/stages/gather_photons.h"
#include "renderer/integrator/stages/path_stages.h"
#include "renderer/integrator/stages/split_view.h"

#include <cstddef>
#include <cstdint>

namespace kindling {

// Base is a sink of PathStages (path_stages.h) that also has
//
//   const PathStages& path_stages
//   PhotonMapView photons_of(const PathInFlight&)   empty: none are gathered
//   size_t slot_of(const PathState&)                of a path
//   size_t last_shadow()                            place of the shadow ray that was added last
template <typename Base>
struct SplitSink : Base {
  static constexpr bool kSplits = true;
  SplitView split;
  SplitShadow offered{}; // of the shadow ray that is added next

  // The first event of a path is that of its first surface: the light that it brings is split
  // like the BSDF's value for the direction that the path takes there.
  void first_surface(const PathStages::Vertex& vertex, const PathInFlight& path) const {
    if (path.state.bounce != 0) return;
    const LobeAlbedos albedos = vertex.bsdf.bsdf().lobe_albedos();
    split.colors[path.slot] = {albedos.diffuse, albedos.glossy, albedos.transmission};
  }
  void scatter_first(const PathStages::Vertex& vertex, const GuidedBsdf::Sample& scattered,
                     const PathInFlight& path) const {
    if (path.state.bounce != 0) return;
    split.firsts[path.slot] = scattered.pdf > 0.0f || scattered.cosine < 0.0f
                                  ? event_at(vertex, scattered.wi, scattered.cosine < 0.0f)
                                  : FirstEvent{FirstEvent::Kind::reflection, Rgb(0.0f)}; // a mirror
  }
  // A medium that the path has entered at its first surface.
  void scatter_event(const accel::Ray& ray, float distance, const V3f& position, const PathState& state) {
    Base::scatter_event(ray, distance, position, state);
    FirstEvent& first = split.firsts[Base::slot_of(state)];
    if (state.scatter_events == 1 && state.bounce <= 1 && first.kind != FirstEvent::Kind::reflection)
      first = {FirstEvent::Kind::volume, Rgb(0.0f)};
  }

  void offer_light(const PathStages::Vertex& vertex, const LightSample& light, const Rgb& contribution) {
    Base::offer_light(vertex, light, contribution);
    offered = {split.groups->of(light), event_at(vertex, light.wi, light.wi.dot(vertex.frame.normal) < 0.0f)};
  }
  void add_shadow(const accel::Ray& ray, const ShadowRecord& record) {
    Base::add_shadow(ray, record);
    split.shadows[Base::last_shadow()] = offered;
  }

  // Light that photons bring to the first surface has its first event there.
  void gather_photons(const PathStages::Vertex& vertex, const PathInFlight& path, float radius2) const {
    const PhotonMapView map = Base::photons_of(path);
    if (map.nodes.empty()) return;
    const auto add_part = [&](const Photon& photon, const Rgb& part) {
      const FirstEvent first = path.state.bounce > 0
                                   ? split.firsts[path.slot]
                                   : event_at(vertex, photon.to_light, photon.to_light.dot(vertex.frame.normal) < 0.0f);
      split.add(path.slot, photon.group, kIndirect, first, LightPass::emit, part);
    };
    path.state.light[kIndirect] += gathered_light(Base::path_stages, map, vertex, path, radius2, add_part);
  }

  void split_emission(const PathInFlight& path, const accel::Hit& hit, const SurfacePoint& surface,
                      const Rgb& light) const {
    add(path, split.groups->of_surface(hit, surface.material), LightPass::emit, light);
  }
  void split_environment(const PathInFlight& path, const Rgb& light) const {
    add(path, split.groups->environment, LightPass::environment, light);
  }
  void split_shapes(const PathStages& stages, const accel::Ray& ray, const accel::Hit& hit,
                    const PathInFlight& path) const {
    if (path.state.bounce == 0) return; // not seen by the camera
    const LightSetView& lights = stages.world->lights;
    lights.visit_shapes(stages.shape_ray(ray, hit, path), [&](uint32_t number, const Rgb& radiance) {
      add(path, split.groups->of_punctual(lights, number), LightPass::emit,
          path.state.throughput * radiance * stages.shape_weight(ray, number, path.state));
    });
  }

 private:
  void add(const PathInFlight& path, uint8_t group, LightPass seen, const Rgb& light) const {
    const PathState& state = path.state;
    split.add(path.slot, group, state.light_class(state.bounce), split.firsts[path.slot], seen, light);
  }
  static FirstEvent event_at(const PathStages::Vertex& vertex, const V3f& wi, bool beyond) {
    return event_towards(vertex.bsdf.bsdf(), vertex.frame.to_local(wi), beyond);
  }
};

} // namespace kindling
