// Points on surfaces, with all data for an integrator, and the flags of the rays that meet them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/base/frame.h"
#include "renderer/base/math.h"
#include "renderer/bsdf/gltf_bsdf.h"
#include "renderer/bsdf/layer_parameters.h"
#include "renderer/light/light_sample.h"

#include <array>
#include <cstdint>

namespace kindling {

// Ray::flags: partly transparent (BLEND) surfaces are hit wherever alpha is above 0, and
// SurfacePoint::alpha is their coverage. Without the flag coverage is decided stochastically during
// traversal, for occlusion rays.
inline constexpr uint32_t kHitPartlyTransparent = 1;
// Ray::flags: surfaces that transmit light in a straight line are not hit where they are smooth
// enough.
inline constexpr uint32_t kPassThinWalls = 2;
// Ray::flags: only such surfaces are hit, wherever their coverage is above 0, besides geometry that
// needs no filter.
inline constexpr uint32_t kHitThinWalls = 4;
// Ray::flags: a ray of the camera, or its straight continuation. Where a World hides backs
// (hides_backs()), such rays pass through them.
inline constexpr uint32_t kCameraRay = 8;
// Ray::flags: meets backs also where a World hides them.
inline constexpr uint32_t kEveryFace = 16;

// The layers of a material at one point of its surface.
struct SurfaceLayers {
  LayerParameters bsdf;       // without eta and clearcoat_normal, which depend on path and frame
  V3f tangent{0.0f};          // world space, the direction of anisotropy; zero: none
  V3f clearcoat_normal{0.0f}; // world space, unit, on the side of wo; only with a coat
  bool boundary = false;      // of a medium: WorldView::medium()
  bool entering = false;      // wo is on its outer side
  bool thin_wall = false;     // light may pass in a straight line: LayeredBsdf::straight_transmittance()
  bool transmits = false;     // transmits light in directions that can be evaluated
};

// A point on a surface, in world space, with all data for an integrator.
struct SurfacePoint {
  V3f position;
  float position_error = 0.0f; // bound of the distance between `position` and the true hit, meters
  V3f geometric_normal;        // unit, on the side of wo
  V3f shading_normal;          // unit, on the side of wo: normal-mapped, corrected where it would face away
  float alpha = 1.0f;          // coverage; below 1 only for BLEND materials
  Rgb emitted{0.0f};           // radiance towards wo where covered
  uint32_t emissive_triangle = accel::kNoId; // index in the LightSet: light sampling can reach it, so MIS applies
  bool unlit = false;                        // reflects nothing: only `emitted` counts
  bool guarded = false;                      // `origins` are valid: the hit is close to another wall, or may be
  bool layered = false;                      // `layers` is valid
  uint32_t material = 0;                     // index for reports, and for WorldView::medium()
  std::array<V3f, 2> origins;                // of new rays: on the side of wo; beyond the surface, if light can pass it
  BsdfParameters bsdf;
  SurfaceLayers layers;

  [[nodiscard]] bool has_thin_wall() const { return layered && layers.thin_wall; }
  // Returns the normal for light sampling: zero if light from all directions counts.
  [[nodiscard]] V3f light_normal() const { return layered && layers.transmits ? V3f(0.0f) : geometric_normal; }
};

// The footprint of a ray on the surface that it hit.
struct RayFootprint {
  float width_m = 0.0f; // diameter of its cone at the hit; 0 reads textures at their finest level
  // True if emission is texture-filtered, for rays without competing light sampling. False if light
  // sampling must see the same emission: the finest level.
  bool filters_emission = false;
  float relative_area = -1.0f; // relative to twice the triangle, by SurfaceFootprint; below 0: not yet known
  float choice = 0.0f;         // likewise, valid if the area is known
};

// Returns an origin for new rays that cannot hit the surface they leave: offset from the surface on
// the side of `direction` by the error bound of the point (Pharr, Jakob and Humphreys, "Physically
// Based Rendering", 4th ed., section 6.8.6). Near edges it is on the inner side of all walls around
// (ray_origins.cpp).
[[nodiscard]] V3f offset_ray_origin(const SurfacePoint& surface, const V3f& direction);

// Returns the shadow ray from a surface to a light sample: it starts off the surface, aims at the
// sampled point from there, and ends just before the light's own surface, by the error bounds of
// both. t is in meters. `time` is that of the ray that hit the surface.
[[nodiscard]] accel::Ray make_shadow_ray(const SurfacePoint& surface, const LightSample& light, uint32_t key,
                                         uint32_t index, float time);

} // namespace kindling
