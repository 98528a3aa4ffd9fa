// Participating media in the path tracer: boundaries, dispersion, absorption, and random walks.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/path_integrator.h"

#include "renderer/base/elementary.h"
#include "renderer/bsdf/dispersion.h"
#include "renderer/integrator/path_recorder.h"
#include "renderer/integrator/path_trace.h"
#include "renderer/integrator/sample_cone.h"
#include "renderer/sampling/warp.h"

#include <cassert>

namespace kindling {
namespace {

constexpr uint32_t kMaxScatterEvents = 1024; // longer walks are absorbed
constexpr uint32_t kFirstRouletteEvent = 16;

// Each event of a walk has its own key for its draws: this one plus its number.
constexpr uint32_t kWalkKey = 0x5ca77e2bU;

Rgb exp_negative(const Rgb& optical_depth) {
  return {elementary::exp(-optical_depth.x), elementary::exp(-optical_depth.y), elementary::exp(-optical_depth.z)};
}

float component_sum(const Rgb& c) { return c.x + c.y + c.z; }

} // namespace

// Finds the media on both sides. A path has one wavelength from its first refraction at a
// dispersive medium on; before that it has all, and each such surface offers a wavelength of its
// own.
PathIntegrator::LayersHere PathIntegrator::resolve_layers(SurfacePoint& surface, const Frame& frame,
                                                          const PathState& state, const MediumStack& media,
                                                          float u_wavelength) const {
  LayersHere here;
  LayerParameters& layers = surface.layers.bsdf;
  here.parameters = &layers;
  if (layers.clearcoat > 0.0f) layers.clearcoat_normal = frame.to_local(surface.layers.clearcoat_normal);
  if (!surface.layers.boundary) {
    layers.eta = surface.bsdf.ior;
    return here;
  }
  const Medium vacuum{.ior = 1.0f};
  const auto medium_of = [&](std::optional<uint32_t> material) -> const Medium& {
    return material ? world_.medium(*material) : vacuum;
  };
  const Medium& own = world_.medium(surface.material);
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

void PathIntegrator::pass_boundary(const SurfacePoint& surface, PathState& state, MediumStack& media) {
  if (!state.in_medium) media.clear();
  if (surface.layers.entering)
    media.enter(surface.material);
  else
    media.leave(surface.material);
  state.in_medium = !media.empty();
}

void PathIntegrator::cross_boundary(const Vertex& vertex, PathState& state, MediumStack& media) {
  if (!vertex.surface.layers.boundary) return;
  if (state.wavelength_nm == 0.0f) state.throughput *= vertex.layers->wavelength_weight;
  state.wavelength_nm = vertex.layers->wavelength_nm;
  pass_boundary(vertex.surface, state, media);
}

Rgb PathIntegrator::medium_transmittance(const MediumStack& media, float distance) const {
  assert(!media.empty() && distance >= 0.0f);
  if (distance == kInfinity) return Rgb(1.0f); // out of an open mesh
  return exp_negative(world_.medium(*media.innermost()).extinction * distance);
}

Rgb PathIntegrator::transmittance_to_light(const Vertex& vertex, float side, float distance,
                                           const PathContext& context) const {
  PathState state = context.states[vertex.slot];
  MediumStack media = state.in_medium ? context.media[vertex.slot] : MediumStack{};
  state.throughput = Rgb(1.0f);
  if (side < 0.0f) cross_boundary(vertex, state, media);
  return state.in_medium ? state.throughput * medium_transmittance(media, distance) : state.throughput;
}

// Spectral multiple importance sampling: the channel that draws the distance is chosen by the
// throughput, and the density is the mean over the channels (Wilkie et al. 2014, "Hero Wavelength
// Spectral Sampling", with three channels).
bool PathIntegrator::travel_medium(size_t i, PathContext& context) const {
  const uint32_t slot = context.active[i];
  PathState& state = context.states[slot];
  const accel::Ray& ray = context.rays[i];
  assert(state.in_medium && !context.media[slot].empty());
  const Medium& medium = world_.medium(*context.media[slot].innermost());
  const float distance = context.hits[i].t;
  if (is_black(medium.scattering)) {
    state.throughput *= exp_negative(medium.extinction * distance);
    return !is_black(state.throughput);
  }

  const CameraSample& sample = context.camera_samples[slot];
  const uint32_t key = hash_combine(sample.address.key, kWalkKey + state.scatter_events);
  const float total = component_sum(state.throughput);
  if (!(total > 0.0f)) return false;
  const Rgb choice = state.throughput / total;
  const V2f u = Sampler::sample_2d(key, sample.address.index, 0);
  const unsigned channel = u.x < choice.x ? 0 : u.x < choice.x + choice.y ? 1 : 2;
  const float chosen = medium.extinction[channel];
  const float t = chosen > 0.0f ? -elementary::log(1.0f - u.y) / chosen : kInfinity;
  if (t >= distance) {
    const Rgb through = exp_negative(medium.extinction * distance);
    state.throughput *= through / component_sum(choice * through);
    return true;
  }

  const Rgb through = exp_negative(medium.extinction * t);
  state.throughput *= medium.scattering * through / component_sum(choice * medium.extinction * through);
  if (++state.scatter_events > kMaxScatterEvents || is_black(state.throughput)) return false;
  if (state.scatter_events >= kFirstRouletteEvent) {
    const float survival = std::min(1.0f, std::sqrt(max_component(state.throughput)));
    if (Sampler::sample_1d(key, sample.address.index, 1) >= survival) return false;
    state.throughput /= survival;
  }
  if (context.recorder) context.recorder->arrive(slot, state, nullptr);

  state.bsdf_pdf = 0.0f; // no light sampling inside media
  state.cone = scattered_cone(state.cone, 0.25f * kInvPi);
  const V3f position = ray.origin + ray.direction * t;
  state.previous_position = position;
  const V3f wi = Frame::around(ray.direction)
                     .to_world(sample_henyey_greenstein(Sampler::sample_2d(key, sample.address.index, 2),
                                                        medium.scatter_anisotropy));
  trace_event(context, [&](PathVertex& vertex) {
    vertex.event = "scattered in a medium";
    vertex.bounce = state.bounce;
    vertex.position = position;
    vertex.direction = ray.direction;
    vertex.distance = t;
    vertex.throughput = state.throughput;
  });
  context.next_active.push_back(slot);
  context.next_rays.push_back({.origin = position,
                               .t_min = 0.0f,
                               .direction = wi,
                               .t_max = kInfinity,
                               .key = key,
                               .time = ray.time,
                               .index = sample.address.index,
                               .flags = kHitPartlyTransparent});
  return false;
}

} // namespace kindling
