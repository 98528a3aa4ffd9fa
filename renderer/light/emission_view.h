// Rays that lights emit towards targets, and their density: the beginnings of light paths.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/light/light_set_view.h"

#include <cstdint>
#include <optional>
#include <span>

namespace kindling {

// A sphere that light is aimed at.
struct EmissionTarget {
  V3f center;
  float radius = 0.0f; // meters, above 0
};

// Random numbers in [0, 1) of one emitted ray.
struct EmissionDraws {
  float light = 0.0f;
  float target = 0.0f;
  V2f position{0.0f};
  V2f direction{0.0f};
  float time = 0.0f; // 0 if nothing moves
};

// A ray that a light emits. Densities are those of rays: per square meter perpendicular to the ray
// and steradian.
struct EmittedRay {
  V3f origin;
  V3f direction;               // unit
  float time = 0.0f;           // in [0, 1] over the shutter
  uint32_t emitter = 0;        // triangles first, then LightSetView::punctuals, then the environment
  Rgb radiance{0.0f};          // of triangles and the environment; of others see EmissionView::radiance()
  float probability = 1.0f;    // of the emitter
  float density = 0.0f;        // of the ray among all lights' rays; kInfinity for lights without a size
  float finite_density = 0.0f; // without the factor of a delta distribution; equal to `density` of lights with a size
};

// Samples rays of all lights. An emitter is chosen in proportion to the light that it sends to all
// targets, unoccluded. Triangles emit from points that are uniform by area, spheres from points of
// a disk through their center that faces the direction. The direction is uniform within the cone
// around a target, which is chosen in proportion to its solid angle. Directional lights choose a
// direction within their disk in the sky, and a point of a disk around a target, in proportion to
// its area; so does the environment, whose directions are those of light samples.
//
// Moving lights emit from where they are at the time of the ray, and all densities take that time.
// The probability of an emitter and the targets are the same at all times.
//
// Immutable, thread-safe, no allocation.
struct EmissionView {
  // Empty: no light reaches a target from the chosen emitter (counts as zero).
  [[nodiscard]] std::optional<EmittedRay> sample(const EmissionDraws& draws) const;
  // Returns the radiance of an emitted ray at a point on it, which light ranges limit; for lights
  // without a size the radiance times the square meters and steradians that the delta distribution
  // leaves out.
  [[nodiscard]] Rgb radiance(const EmittedRay& ray, const V3f& at) const;

  // Return `EmittedRay::density` of a ray that leaves a light at `point`, or passes through it,
  // along `direction` (unit); 0 if sample() does not return it. `cosine` is that between the
  // direction and the triangle's normal.
  [[nodiscard]] float triangle_density(uint32_t triangle, const V3f& point, const V3f& direction, float cosine,
                                       float time = 0.0f) const;
  [[nodiscard]] float punctual_density(uint32_t number, const V3f& point, const V3f& direction,
                                       float time = 0.0f) const;
  // For a direction to the sky, -direction: its density and radiance in the environment.
  [[nodiscard]] float environment_density(const EnvironmentEval& sky, const V3f& point, const V3f& direction) const {
    if (!is_bright(sky.radiance)) return 0.0f;
    return probability(environment_emitter()) * sky.pdf * disk_density(point, direction);
  }

  [[nodiscard]] bool empty() const { return cdf.size() < 2 || targets.empty(); }
  [[nodiscard]] float probability(size_t emitter) const { return cdf[emitter + 1] - cdf[emitter]; }
  // True if light paths begin at places of the environment that are as bright as this. Paths from
  // the camera find others well enough.
  [[nodiscard]] bool is_bright(const Rgb& radiance) const { return luminance(radiance) > bright_sky; }
  [[nodiscard]] size_t environment_emitter() const { return lights->triangles.size() + lights->punctuals.size(); }
  // Returns the sum of the solid angles of the targets, steradians.
  [[nodiscard]] float solid_angle(const V3f& from) const;
  // Density of directions from a point towards the targets, per steradian; 0: towards none.
  [[nodiscard]] float direction_density(const V3f& from, const V3f& direction) const;
  // Density of parallel rays through the targets' disks, per square meter.
  [[nodiscard]] float disk_density(const V3f& point, const V3f& direction) const;

  // Steps of sample(), for the chosen emitter; `number` is an index into LightSetView::punctuals.
  // False: it is dark there.
  [[nodiscard]] bool emit_from_triangle(const EmissionDraws& draws, EmittedRay& ray) const;
  void emit_from_sphere(uint32_t number, const EmissionDraws& draws, EmittedRay& ray) const;
  void emit_from_sun(uint32_t number, const EmissionDraws& draws, EmittedRay& ray) const;
  void emit_from_environment(const EmissionDraws& draws, EmittedRay& ray) const;
  [[nodiscard]] V3f sample_disks(const EmissionDraws& draws, const V3f& direction) const;
  // Return lights as they are at a time.
  [[nodiscard]] LightSetView::Triangle triangle_at(uint32_t number, float time) const {
    return lights->moves(number) ? lights->posed_triangle(number, time) : lights->triangles[number];
  }
  [[nodiscard]] LightSetView::Punctual punctual_at(uint32_t number, float time) const {
    const LightSetView::Punctual& light = lights->punctuals[number];
    return light.key_count == 0 ? light : lights->posed(light, time);
  }

  const LightSetView* lights = nullptr;
  std::span<const EmissionTarget> targets;
  std::span<const float> cdf; // by emitter, from 0 to 1; one more than there are emitters
  float disk_area = 0.0f;     // sum over the targets, square meters
  float bright_sky = 0.0f;    // luminance, W / (sr m^2)
  float reach = 0.0f;         // diameter of a sphere around the scene, meters
};

} // namespace kindling
