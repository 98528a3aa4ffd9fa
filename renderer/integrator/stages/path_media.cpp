// Participating media along one path: boundaries, dispersion and absorption.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/dispersion.h"
#include "renderer/integrator/stages/path_stages.h"
#include "renderer/integrator/stages/random_walk.h"

#include <cassert>

namespace kindling {

PathStages::LayersHere PathStages::resolve_layers(SurfacePoint& surface, const Frame& frame, const PathState& state,
                                                  const MediumStack& media, float u_wavelength) const {
  LayerParameters& layers = surface.layers.bsdf;
  if (layers.clearcoat > 0.0f) layers.clearcoat_normal = frame.to_local(surface.layers.clearcoat_normal);
  return resolve_media(surface, state, media, u_wavelength);
}

// A path has one wavelength from its first refraction at a dispersive medium on; before that it has
// all, and each such surface offers a wavelength of its own.
PathStages::LayersHere PathStages::resolve_media(SurfacePoint& surface, const PathState& state,
                                                 const MediumStack& media, float u_wavelength) const {
  LayersHere here;
  LayerParameters& layers = surface.layers.bsdf;
  here.parameters = &layers;
  if (!surface.layers.boundary) {
    layers.eta = surface.bsdf.ior;
    return here;
  }
  const Medium vacuum{.ior = 1.0f};
  const auto medium_of = [&](std::optional<uint32_t> material) -> const Medium& {
    return material ? world->medium(*material) : vacuum;
  };
  const Medium& own = world->medium(surface.material);
  const std::optional<uint32_t> beside = !state.in_medium          ? std::nullopt
                                         : surface.layers.entering ? media.innermost()
                                                                   : media.innermost_without(surface.material);
  const Medium& other = medium_of(beside);
  here.wavelength_nm = state.wavelength_nm;
  if (here.wavelength_nm == 0.0f && std::max(own.dispersion, other.dispersion) > 0.0f) {
    const WavelengthSample wavelength = sample_wavelength(u_wavelength);
    here.wavelength_nm = wavelength.nm;
    here.wavelength_weight = wavelength.weight;
  }
  const auto ior = [&](const Medium& medium) {
    return medium.dispersion > 0.0f ? dispersed_ior(medium.ior, medium.dispersion, here.wavelength_nm) : medium.ior;
  };
  layers.eta = surface.layers.entering ? ior(own) / ior(other) : ior(other) / ior(own);
  return here;
}

void PathStages::pass_boundary(const SurfacePoint& surface, PathState& state, MediumStack& media) {
  if (!state.in_medium)
    media.clear();
  else if (surface.layers.entering)
    state.light_path_scale = 0.0f; // light paths know one medium at a time
  if (surface.layers.entering)
    media.enter(surface.material);
  else
    media.leave(surface.material);
  state.in_medium = !media.empty();
}

void PathStages::cross_boundary(const SurfacePoint& surface, const LayersHere& layers, PathState& state,
                                MediumStack& media) {
  if (!surface.layers.boundary) return;
  if (state.wavelength_nm == 0.0f) state.throughput *= layers.wavelength_weight;
  state.wavelength_nm = layers.wavelength_nm;
  pass_boundary(surface, state, media);
}

Rgb PathStages::medium_transmittance(const MediumStack& media, float distance) const {
  assert(!media.empty() && distance >= 0.0f);
  if (distance == kInfinity) return Rgb(1.0f); // out of an open mesh
  return exp_negative(world->medium(*media.innermost()).extinction * distance);
}

Rgb PathStages::transmittance_to_light(const SurfacePoint& surface, const LayersHere* layers, float side,
                                       float distance, const PathInFlight& path) const {
  PathState state = path.state;
  MediumStack media = state.in_medium ? path.media : MediumStack{};
  state.throughput = Rgb(1.0f);
  if (side < 0.0f && layers) cross_boundary(surface, *layers, state, media);
  return state.in_medium ? state.throughput * medium_transmittance(media, distance) : state.throughput;
}

} // namespace kindling
