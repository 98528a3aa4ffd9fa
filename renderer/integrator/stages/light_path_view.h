// Weights of multiple importance sampling between light paths and those from the camera.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/ray.h"
#include "renderer/camera/camera.h"
#include "renderer/light/emission_view.h"
#include "renderer/world/surface_point.h"

#include <cstdint>
#include <span>

namespace kindling {

// Light paths run from a light over one or more casters to a surface that is none, and are joined
// to the camera there. A caster is a surface with a material that focuses light. All other paths
// are left to those from the camera.
//
// Both kinds of paths find the same light, so each is weighted by the power heuristic (Veach 1997).
// Its densities are those of the light's ray, and of a camera ray that continues in proportion to
// the cosine. Étendue is conserved between them along any chain of mirrors and refractions, so the
// weight depends on the ends of a path alone. That is exact for smooth casters; for others it is a
// weight that still sums to 1.
struct LightPathView {
  static constexpr int kMaxBounces = 32; // longer paths are left to the camera's

  EmissionView emission;
  std::span<const uint8_t> casters; // by material: 1 if it is one
  float paths_per_pass = 0.0f;      // light paths while each pixel of the image takes one sample

  [[nodiscard]] bool is_caster(uint32_t material) const { return casters[material] != 0; }

  // Returns what the density of a light's ray is multiplied with for its ratio to the density of
  // paths from the camera. `camera_px` is the density of camera rays at the surface, in pixels per
  // square meter.
  [[nodiscard]] float ratio_scale(float camera_px) const { return paths_per_pass * kPi / camera_px; }

  // Returns the density of camera rays at a surface with this normal, in pixels per square meter.
  // `direction` is that of the ray, unit.
  [[nodiscard]] static float camera_density(const CameraView& camera, const V3f& direction, float distance,
                                            const V3f& normal) {
    const float facing = std::abs(normal.dot(direction));
    if (camera.orthographic) return facing / square(camera.pixel);
    const float cosine = direction.dot(camera.basis.forward);
    return facing / (square(distance * camera.pixel) * cosine * cosine * cosine);
  }

  // Return the weights of a light path, and of one from the camera, for a ratio of densities; they
  // sum to 1.
  [[nodiscard]] static float light_weight(float ratio) {
    return ratio > 0.0f ? 1.0f / (1.0f + 1.0f / square(ratio)) : 0.0f;
  }
  [[nodiscard]] static float camera_weight(float ratio) { return 1.0f / (1.0f + square(ratio)); }
};

} // namespace kindling
