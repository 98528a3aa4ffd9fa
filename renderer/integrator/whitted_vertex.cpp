// Media, dispersion and highlight BSDF at a surface of the Whitted tracer.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/whitted_vertex.h"

#include "renderer/base/elementary.h"
#include "renderer/bsdf/dispersion.h"
#include "renderer/sampling/sampler.h"

#include <cassert>

namespace kindling {
namespace {

constexpr uint32_t kWavelengthKey = 0x3a7e1e9bU;

Frame frame_of(const SurfacePoint& surface) {
  return surface.layered ? Frame::with_tangent(surface.shading_normal, surface.layers.tangent)
                         : Frame::around(surface.shading_normal);
}

} // namespace

Rgb medium_transmittance(const WorldView& world, const MediumStack& media, float distance) {
  assert(!media.empty() && distance >= 0.0f);
  if (distance == kInfinity) return Rgb(1.0f);
  const Rgb& extinction = world.medium(*media.innermost()).extinction;
  return {elementary::exp(-extinction.x * distance), elementary::exp(-extinction.y * distance),
          elementary::exp(-extinction.z * distance)};
}

WhittedVertex::WhittedVertex(const WorldView& world, const WhittedNode& node_above, SurfacePoint& surface_here,
                             const WhittedTerms& terms_here, float highlight_roughness)
    : node(node_above), surface(surface_here), terms(terms_here), frame(frame_of(surface_here)),
      wo(frame.to_local(-node_above.ray.direction)), world_(world), highlight_roughness_(highlight_roughness),
      blurred_(surface_here.bsdf.roughness < highlight_roughness) {
  if (surface.layered) resolve_media(surface_here);
}

// As in the path tracer: light that is refracted at a dispersive medium keeps one wavelength from
// there on.
void WhittedVertex::resolve_media(SurfacePoint& mutable_surface) {
  LayerParameters& layers = mutable_surface.layers.bsdf;
  layers_ = &layers;
  blurred_ |= layers.clearcoat > 0.0f && layers.clearcoat_roughness < highlight_roughness_;
  if (layers.clearcoat > 0.0f) layers.clearcoat_normal = frame.to_local(surface.layers.clearcoat_normal);
  if (!surface.layers.boundary) {
    layers.eta = surface.bsdf.ior;
    return;
  }
  const Medium vacuum{.ior = 1.0f};
  const Medium& own = world_.medium(surface.material);
  const std::optional<uint32_t> beside = !node.in_medium           ? std::nullopt
                                         : surface.layers.entering ? node.media.innermost()
                                                                   : node.media.innermost_without(surface.material);
  const Medium& other = beside ? world_.medium(*beside) : vacuum;
  wavelength_nm_ = node.wavelength_nm;
  if (wavelength_nm_ == 0.0f && std::max(own.dispersion, other.dispersion) > 0.0f) {
    const WavelengthSample wavelength =
        sample_wavelength(Sampler::sample_1d(node.ray.key, node.ray.index, kWavelengthKey));
    wavelength_nm_ = wavelength.nm;
    wavelength_weight_ = wavelength.weight;
  }
  const auto ior = [&](const Medium& medium) {
    return medium.dispersion > 0.0f ? dispersed_ior(medium.ior, medium.dispersion, wavelength_nm_) : medium.ior;
  };
  layers.eta = surface.layers.entering ? ior(own) / ior(other) : ior(other) / ior(own);
}

void WhittedVertex::make_highlight() const {
  BsdfParameters parameters = surface.bsdf;
  parameters.roughness = std::max(parameters.roughness, highlight_roughness_);
  if (!layers_) {
    highlight_.emplace(parameters, nullptr, wo);
    return;
  }
  LayerParameters layers = *layers_;
  layers.clearcoat_roughness = std::max(layers.clearcoat_roughness, highlight_roughness_);
  highlight_.emplace(parameters, &layers, wo);
}

// f is divided among its lobes by their densities, exactly as sampling of a single lobe weights it.
float WhittedVertex::share_of_lights(const V3f& wi, float pdf) const {
  if (!terms.traced || !(pdf > 0.0f)) return 1.0f;
  float followed;
  if (const LayeredBsdf* layered = bsdf().layers()) {
    followed = terms.mirror_share * layered->choice_density(LayeredBsdf::kGlossy, wi) +
               terms.coat_mirror_share * layered->choice_density(LayeredBsdf::kCoat, wi) +
               terms.glass_share * layered->choice_density(LayeredBsdf::kGlass, wi);
  } else {
    followed =
        terms.mirror_share * std::max(pdf - (1.0f - bsdf().cosine_begin()) * std::max(wi.z, 0.0f) * kInvPi, 0.0f);
  }
  return std::max(1.0f - followed / pdf, 0.0f);
}

void WhittedVertex::cross(WhittedNode& below) const {
  if (!surface.layered || !surface.layers.boundary) return;
  if (node.wavelength_nm == 0.0f) below.weight *= wavelength_weight_;
  below.wavelength_nm = wavelength_nm_;
  if (!below.in_medium) below.media.clear();
  if (surface.layers.entering)
    below.media.enter(surface.material);
  else
    below.media.leave(surface.material);
  below.in_medium = !below.media.empty();
}

Rgb WhittedVertex::transmittance_to_light(float side, float distance) const {
  WhittedNode beyond;
  beyond.in_medium = node.in_medium;
  if (node.in_medium) beyond.media = node.media;
  if (side < 0.0f) cross(beyond);
  return beyond.in_medium ? beyond.weight * medium_transmittance(world_, beyond.media, distance) : beyond.weight;
}

} // namespace kindling
