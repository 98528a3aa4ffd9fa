// A surface on a light path as it is seen from one side.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/stages/light_path_view.h"
#include "renderer/integrator/stages/path_stages.h"

#include <optional>

namespace kindling {

// The BSDF of a surface that is seen along wo, with the frame that it refers to.
struct SeenSurface {
  SurfacePoint& surface; // look() completes its layers
  Frame frame{};
  std::optional<SurfaceBsdf> bsdf{};
  PathStages::LayersHere layers{};

  // Returns the surface at a position that the camera sees along `direction`, outside of media and
  // in all wavelengths.
  [[nodiscard]] static SeenSurface from_camera(const PathStages& stages, const V3f& position, const V3f& direction,
                                               const accel::Hit& hit, float time, SurfacePoint& scratch) {
    SeenSurface seen{scratch};
    seen.find(*stages.world, position, -direction, hit, time);
    seen.look(stages, -direction, false, 0, 0.0f, 0.0f);
    return seen;
  }
  // Evaluates the surface at a hit as it is seen from a direction.
  void find(const WorldView& world, const V3f& position, const V3f& wo, const accel::Hit& hit, float time) {
    const accel::Ray ray{.origin = position + wo, .direction = -wo, .time = time};
    accel::Hit seen = hit;
    seen.t = 1.0f;
    world.surface_at(ray, seen, surface);
  }
  // `in_medium`: the side of wo is inside of the medium `material`. `wavelength_nm`: 0 for all, of
  // which dispersive glass chooses one by `u_wavelength`.
  void look(const PathStages& stages, const V3f& wo, bool in_medium, uint32_t material, float wavelength_nm,
            float u_wavelength) {
    if (!surface.layered) {
      frame = Frame::around(surface.shading_normal);
      bsdf.emplace(surface.bsdf, nullptr, frame.to_local(wo));
      return;
    }
    frame = Frame::with_tangent(surface.shading_normal, surface.layers.tangent);
    PathState state;
    MediumStack media;
    if (in_medium) media.enter(material);
    state.in_medium = in_medium;
    state.wavelength_nm = wavelength_nm;
    layers = stages.resolve_layers(surface, frame, state, media, u_wavelength);
    bsdf.emplace(surface.bsdf, &surface.layers.bsdf, frame.to_local(wo));
  }
  // Returns f |cos| for light from wi; black where shading and geometric normal disagree on its
  // side.
  [[nodiscard]] Rgb eval(const V3f& wi) const {
    const float side = wi.dot(surface.geometric_normal);
    if (!surface.layered && side <= 0.0f) return Rgb(0.0f);
    if ((side > 0.0f) != (wi.dot(frame.normal) > 0.0f)) return Rgb(0.0f);
    return bsdf->eval(frame.to_local(wi)).value;
  }
  // Returns LightPathView::narrow_steps() for light from wi.
  [[nodiscard]] uint32_t narrow_steps(const V3f& wi) const {
    return LightPathView::narrow_steps(*bsdf, frame.to_local(wi), false);
  }
};

} // namespace kindling
