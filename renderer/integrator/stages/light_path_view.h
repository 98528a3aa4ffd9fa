// Weights of multiple importance sampling between light paths and those from the camera.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/ray.h"
#include "renderer/base/elementary.h"
#include "renderer/bsdf/narrow_lobes.h"
#include "renderer/camera/camera.h"
#include "renderer/light/emission_view.h"
#include "renderer/world/surface_point.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

namespace kindling {

// Light paths run from a light over one or more surfaces, the first of which is a caster, to
// another one, and are joined to the camera there. A caster is a surface whose material focuses
// light by narrow lobes (narrow_lobes.h). Of what other lobes of a caster reflect, light paths find
// nothing, and they are not joined to the camera by narrow ones: such light is left to paths from
// the camera, in proportion to the densities of the lobes.
//
// Both kinds of paths find the same light, so each is weighted by the power heuristic (Veach 1997).
// Its densities are those of the light's ray, and of a camera ray that continues in proportion to
// the cosine. Étendue is conserved between them along any chain of mirrors and refractions, so the
// weight depends on the ends of a path alone. That is exact for smooth casters; for others it is a
// weight that still sums to 1.
//
// A surface that the camera sees over casters is on no straight line from it. Light paths leave
// photons there (photons/photon_maps.h), which are joined to paths from the camera that pass
// nearby.
struct LightPathView {
  static constexpr int kMaxBounces = 32;            // longer paths are left to the camera's
  static constexpr float kMaxNarrowAlpha = 0.1225f; // of a caster's lobes: roughness 0.35
  static constexpr uint32_t kShares = 255;          // steps of PathState::first_share and last_share

  EmissionView emission;
  std::span<const uint8_t> casters; // by material: 1 if it is one
  float paths_per_pass = 0.0f;      // light paths while each pixel of the image takes one sample
  float photons_per_pass = 0.0f;    // the same for photons; 0: there are none
  uint32_t samples_per_map = 1;     // of a pixel, which share photons
  float max_photon_radius_m = 0.0f; // from the casters' size

  [[nodiscard]] bool is_caster(uint32_t material) const { return casters[material] != 0; }

  // Returns what the density of a light's ray is multiplied with for its ratio to the density of
  // paths from the camera. `camera_px` is the density of camera rays at the surface, in pixels per
  // square meter.
  [[nodiscard]] float ratio_scale(float camera_px) const { return paths_per_pass * kPi / camera_px; }

  // Returns the same at a surface where photons are gathered within a radius.
  [[nodiscard]] float photon_ratio_scale(float radius2) const { return photons_per_pass * kPi * (kPi * radius2); }

  // Returns how far the times of photons are at most from that of a path that gathers them, in
  // units of the shutter interval, if something moves. It shrinks like the radius, so both blur the
  // less the more samples there are.
  [[nodiscard]] float photon_time_span(uint32_t sample) const {
    constexpr float kFirst = 0.125f; // with the first map
    return kFirst * elementary::pow(samples_before_map(sample), -1.0f / 6.0f);
  }
  // Returns the density of a photon's time around that of a path. It is mirrored at both ends of
  // the shutter interval, so its mean over all times of either is 1 for each time of the other.
  [[nodiscard]] static float photon_time_density(float path_time, float photon_time, float span) {
    const float sum = path_time + photon_time;
    const int found =
        (std::abs(path_time - photon_time) < span ? 1 : 0) + (sum < span ? 1 : 0) + (2.0f - sum < span ? 1 : 0);
    return static_cast<float>(found) / (2.0f * span);
  }

  // Returns the square of the radius within which a sample of a pixel gathers photons, given the
  // width of the pixel's cone there. It shrinks from map to map, so that the mean of all samples
  // converges to the image without bias (Knaus and Zwicker 2011, "Progressive Photon Mapping: A
  // Probabilistic Approach", with alpha = 2/3).
  [[nodiscard]] float photon_radius2(float pixel_width_m, uint32_t sample) const {
    constexpr float kPixels = 1.5f; // with the first map
    return square(std::min(kPixels * pixel_width_m, max_photon_radius_m)) *
           elementary::pow(samples_before_map(sample), -1.0f / 3.0f);
  }
  // Returns the number of samples before those of the map of a sample, and one.
  [[nodiscard]] float samples_before_map(uint32_t sample) const {
    return static_cast<float>(sample / samples_per_map * samples_per_map + 1);
  }

  // Returns the density of camera rays of a time at a surface with this normal, in pixels per
  // square meter. `direction` is that of the ray, unit.
  [[nodiscard]] static float camera_density(const CameraView& camera, const V3f& direction, float distance,
                                            const V3f& normal, float time) {
    const float facing = std::abs(normal.dot(direction));
    if (camera.orthographic) return facing / square(camera.pixel);
    const float cosine = direction.dot(camera.basis_at(time).forward);
    return facing / (square(distance * camera.pixel) * cosine * cosine * cosine);
  }

  // Return the weights of a light path, and of one from the camera, for a ratio of densities; they
  // sum to 1.
  [[nodiscard]] static float light_weight(float ratio) {
    return ratio > 0.0f ? 1.0f / (1.0f + 1.0f / square(ratio)) : 0.0f;
  }
  [[nodiscard]] static float camera_weight(float ratio) { return 1.0f / (1.0f + square(ratio)); }

  // Returns true if an event at dispersive glass leaves a path to those from the camera: such glass
  // refracts it and, outside of it, reflects it. A path from the camera takes on its wavelength at
  // its first refraction, and reflections before it are those of all wavelengths; seen from the
  // light the order is another. `dispersed`: it was refracted before; `reflected`: it was reflected
  // outside.
  [[nodiscard]] static bool mixes_colors(bool crosses, bool inside, bool dispersed, bool reflected) {
    return crosses ? reflected : !inside && dispersed;
  }

  // Returns the narrow share of what a surface scatters from the camera's side into a local
  // direction, in 1 / kShares. Paths of both kinds compute the same number. `delta`: it is a delta
  // direction.
  [[nodiscard]] static uint8_t narrow_steps(const SurfaceBsdf& bsdf, const V3f& wi, bool delta) {
    const float pdf = delta ? 0.0f : bsdf.eval(wi).pdf;
    return steps_of(delta || pdf > 0.0f ? narrow_share(bsdf, wi, pdf, kMaxNarrowAlpha) : 0.0f);
  }
  [[nodiscard]] static uint8_t steps_of(float share) {
    return static_cast<uint8_t>(share * static_cast<float>(kShares) + 0.5f);
  }
  // Returns the share that light paths find, given those of the first surface and the last caster.
  [[nodiscard]] static float share_of(uint32_t first, uint32_t last) {
    return static_cast<float>(first * last) / static_cast<float>(kShares * kShares);
  }
};

} // namespace kindling
