// The light of the photons near a surface that a path from the camera has reached.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/stages/path_stages.h"
#include "renderer/integrator/stages/photon_view.h"
#include "renderer/integrator/stages/rest_surface.h"

#include <cmath>

namespace kindling {

// Returns the light that photons within the root of `radius2` around the vertex send along the
// path, weighted against paths from the camera. The path is joined there
// (PathState::light_path_scale < 0).
[[nodiscard]] Rgb gathered_light(const PathStages& stages, const PhotonMapView& map, const PathStages::Vertex& vertex,
                                 const PathInFlight& path, float radius2);

// The same; calls visit(photon, part) for each photon that has a part in it, always in the same
// order.
template <typename Visit>
[[nodiscard]] inline Rgb gathered_light(const PathStages& stages, const PhotonMapView& map,
                                        const PathStages::Vertex& vertex, const PathInFlight& path, float radius2,
                                        const Visit& visit) {
  // Photons of other surfaces nearby do not count: those that face elsewhere, and those that are
  // off the tangent plane by more than this part of the radius.
  constexpr float kMinFacing = 0.7f;
  constexpr float kMaxOffPlane = 0.5f;
  const PathState& state = path.state;
  const SurfacePoint& surface = vertex.surface;
  const LightPathView& paths = *stages.light_paths;
  const uint32_t medium = state.in_medium ? *path.media.innermost() : Photon::kNoMedium;
  const bool caster = paths.is_caster(surface.material);
  // Photons are at rest. The disk there is the one that has the radius at the path's time.
  const bool moves = stages.world->has_motion;
  RestSurface rest{surface.position, surface.geometric_normal};
  float span = 0.0f;
  if (moves) {
    rest = rest_surface(*stages.world, surface, vertex.hit, vertex.time);
    radius2 *= rest.area_ratio;
    span = paths.photon_time_span(path.map_sample);
  }
  const float off_plane2 = kMaxOffPlane * kMaxOffPlane * radius2;
  const float scale = 1.0f / (kPi * radius2);
  Rgb sum(0.0f);
  map.for_each_near(rest.position, radius2, [&](const Photon& photon) {
    if (photon.medium != medium || std::abs(photon.normal.dot(rest.normal)) < kMinFacing) return;
    if (square((photon.position - rest.position).dot(rest.normal)) > off_plane2) return;
    const float time_density = moves ? LightPathView::photon_time_density(vertex.time, photon.time, span) : 1.0f;
    if (time_density == 0.0f) return;
    const float side = photon.to_light.dot(surface.geometric_normal);
    if (vertex.layers ? (side > 0.0f) != (photon.to_light.dot(vertex.frame.normal) > 0.0f) : !(side > 0.0f)) return;
    if (!stages.within_limits(state.diffuse_bounces() + 1 + photon.diffuse, state.glossy_bounces + photon.glossy,
                              state.transmission_bounces + photon.transmission))
      return; // the vertex itself is a diffuse bounce
    Rgb value = vertex.bsdf.bsdf().eval(vertex.frame.to_local(photon.to_light)).value;
    if (caster)
      value *= LightPathView::share_of(
          LightPathView::kShares -
              LightPathView::narrow_steps(vertex.bsdf.bsdf(), vertex.frame.to_local(photon.to_light), false),
          LightPathView::kShares);
    const Rgb light = value * photon.power *
                      (time_density * LightPathView::light_weight(std::abs(state.light_path_scale) * photon.density));
    sum += light;
    visit(photon, state.throughput * light * scale);
  });
  return state.throughput * sum * scale;
}

} // namespace kindling
