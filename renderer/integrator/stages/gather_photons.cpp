// Evaluates the photons near a vertex.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/gather_photons.h"

#include <cmath>

namespace kindling {
namespace {

// Photons of other surfaces nearby do not count: those that face elsewhere, and those that are off
// the tangent plane by more than this part of the radius.
constexpr float kMinFacing = 0.7f;
constexpr float kMaxOffPlane = 0.5f;

} // namespace

Rgb gathered_light(const PathStages& stages, const PhotonMapView& map, const PathStages::Vertex& vertex,
                   const PathInFlight& path, float radius2) {
  const PathState& state = path.state;
  const SurfacePoint& surface = vertex.surface;
  const LightPathView& paths = *stages.light_paths;
  const uint32_t medium = state.in_medium ? *path.media.innermost() : Photon::kNoMedium;
  const bool caster = paths.is_caster(surface.material);
  const float off_plane2 = kMaxOffPlane * kMaxOffPlane * radius2;
  Rgb sum(0.0f);
  map.for_each_near(surface.position, radius2, [&](const Photon& photon) {
    if (photon.medium != medium || std::abs(photon.normal.dot(surface.geometric_normal)) < kMinFacing) return;
    if (square((photon.position - surface.position).dot(surface.geometric_normal)) > off_plane2) return;
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
    sum += value * photon.power * LightPathView::light_weight(std::abs(state.light_path_scale) * photon.density);
  });
  return state.throughput * sum * (1.0f / (kPi * radius2));
}

} // namespace kindling
