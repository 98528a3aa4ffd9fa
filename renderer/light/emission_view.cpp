// Sampling and density of the rays that lights emit towards targets.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/emission_view.h"

#include "renderer/base/frame.h"
#include "renderer/sampling/warp.h"

#include <algorithm>
#include <cassert>

namespace kindling {

namespace {

using Kind = LightSetView::Punctual::Kind;

constexpr float kAllDirections = 2.0f;

// 1 - cos of half the cone around a target, seen from a point; kAllDirections from inside.
float one_minus_cos(const EmissionTarget& target, const V3f& from) {
  const float distance2 = (target.center - from).length2();
  const float sin2 = square(target.radius) / distance2;
  if (!(sin2 < 1.0f)) return kAllDirections;
  return sin2 / (1.0f + std::sqrt(1.0f - sin2));
}

bool in_cone(const EmissionTarget& target, const V3f& from, const V3f& direction, float width) {
  const V3f to_center = target.center - from;
  // Against |direction - axis|^2 = 2 (1 - cos), which keeps the digits of narrow cones.
  return width == kAllDirections || (direction - to_center.normalized()).length2() <= 2.0f * width;
}

// Returns the target at which the running sum of `share` passes u times the sum of all.
template <typename Share>
const EmissionTarget& choose_target(std::span<const EmissionTarget> targets, float u, const Share& share) {
  float sum = 0.0f;
  for (const EmissionTarget& target : targets) sum += share(target);
  float rest = u * sum;
  for (const EmissionTarget& target : targets) {
    rest -= share(target);
    if (rest < 0.0f) return target;
  }
  return targets.back();
}

V3f sample_towards(const EmissionTarget& target, const V3f& from, const V2f& u) {
  const float width = one_minus_cos(target, from);
  if (width == kAllDirections) return sample_uniform_sphere(u);
  return Frame::around((target.center - from).normalized()).to_world(sample_uniform_cone(u, width));
}

} // namespace

float EmissionView::solid_angle(const V3f& from) const {
  float sum = 0.0f;
  for (const EmissionTarget& target : targets) sum += one_minus_cos(target, from);
  return 2.0f * kPi * sum;
}

float EmissionView::direction_density(const V3f& from, const V3f& direction) const {
  float sum = 0.0f, inside = 0.0f;
  for (const EmissionTarget& target : targets) {
    const float width = one_minus_cos(target, from);
    sum += width;
    inside += in_cone(target, from, direction, width) ? 1.0f : 0.0f;
  }
  return inside * 0.5f * kInvPi / sum;
}

float EmissionView::disk_density(const V3f& point, const V3f& direction) const {
  float inside = 0.0f;
  for (const EmissionTarget& target : targets)
    inside += (point - target.center).cross(direction).length2() <= square(target.radius) ? 1.0f : 0.0f;
  return inside / disk_area;
}

float EmissionView::triangle_density(uint32_t triangle, const V3f& point, const V3f& direction, float cosine,
                                     float time) const {
  assert(triangle < lights->triangles.size());
  const float area = 0.5f * double_area_normal(triangle_at(triangle, time)).length();
  return probability(triangle) * direction_density(point, direction) / (area * std::abs(cosine));
}

float EmissionView::punctual_density(uint32_t number, const V3f& point, const V3f& direction, float time) const {
  assert(number < lights->punctuals.size());
  const LightSetView::Punctual light = punctual_at(number, time);
  const float chance = probability(lights->triangles.size() + number);
  if (light.kind == Kind::directional) {
    const float through = chance * disk_density(point, direction);
    if (light.radius > 0.0f) return through * 0.5f * kInvPi / light.one_minus_cos;
    return through > 0.0f ? kInfinity : 0.0f;
  }
  const float towards = chance * direction_density(light.position, direction);
  if (light.radius > 0.0f) return towards * kInvPi / square(light.radius);
  return towards > 0.0f ? kInfinity : 0.0f;
}

std::optional<EmittedRay> EmissionView::sample(const EmissionDraws& draws) const {
  assert(!empty());
  const auto after = std::upper_bound(cdf.begin() + 1, cdf.end() - 1, draws.light);
  EmittedRay ray;
  ray.time = draws.time;
  ray.emitter = static_cast<uint32_t>(after - cdf.begin()) - 1;
  ray.probability = probability(ray.emitter);
  if (!(ray.probability > 0.0f)) return std::nullopt;
  if (ray.emitter < lights->triangles.size()) {
    if (!emit_from_triangle(draws, ray)) return std::nullopt;
  } else if (ray.emitter == environment_emitter()) {
    emit_from_environment(draws, ray);
  } else if (const uint32_t number = ray.emitter - static_cast<uint32_t>(lights->triangles.size());
             lights->punctuals[number].kind == Kind::directional) {
    emit_from_sun(number, draws, ray);
  } else {
    emit_from_sphere(number, draws, ray);
  }
  if (!(ray.density > 0.0f)) return std::nullopt;
  return ray;
}

bool EmissionView::emit_from_triangle(const EmissionDraws& draws, EmittedRay& ray) const {
  const LightSetView::Triangle triangle = triangle_at(ray.emitter, ray.time);
  const V2f at = sample_uniform_triangle(draws.position);
  ray.origin = triangle.p0 * (1.0f - at.x - at.y) + triangle.p1 * at.x + triangle.p2 * at.y;
  const EmissionTarget& target =
      choose_target(targets, draws.target, [&](const EmissionTarget& t) { return one_minus_cos(t, ray.origin); });
  ray.direction = sample_towards(target, ray.origin, draws.direction);
  const V3f normal = double_area_normal(triangle);
  const float cosine = normal.dot(ray.direction) / normal.length();
  const Emission& emission = lights->emissions[triangle.emission];
  if (!(cosine > 0.0f || (cosine < 0.0f && emission.two_sided))) return false;
  ray.radiance = lights->emission_at(ray.emitter, at.x, at.y) *
                 LightSetView::through_coat(emission, cosine > 0.0f, std::abs(cosine));
  ray.density = triangle_density(ray.emitter, ray.origin, ray.direction, cosine, ray.time);
  ray.finite_density = ray.density;
  return true;
}

void EmissionView::emit_from_sphere(uint32_t number, const EmissionDraws& draws, EmittedRay& ray) const {
  const LightSetView::Punctual light = punctual_at(number, ray.time);
  const EmissionTarget& target =
      choose_target(targets, draws.target, [&](const EmissionTarget& t) { return one_minus_cos(t, light.position); });
  ray.direction = sample_towards(target, light.position, draws.direction);
  ray.density = punctual_density(number, light.position, ray.direction, ray.time);
  ray.finite_density =
      light.radius > 0.0f ? ray.density : ray.probability * direction_density(light.position, ray.direction);
  const V2f on_disk = sample_uniform_disk(draws.position);
  const V3f on_sphere(on_disk.x, on_disk.y, safe_sqrt(1.0f - on_disk.length2()));
  ray.origin = light.position + Frame::around(ray.direction).to_world(on_sphere) * light.radius;
}

// Returns a point of a disk around a target that faces the direction.
V3f EmissionView::sample_disks(const EmissionDraws& draws, const V3f& direction) const {
  const EmissionTarget& target =
      choose_target(targets, draws.target, [](const EmissionTarget& t) { return square(t.radius); });
  const V2f on_disk = sample_uniform_disk(draws.position) * target.radius;
  return target.center + Frame::around(direction).to_world(V3f(on_disk.x, on_disk.y, 0.0f));
}

void EmissionView::emit_from_sun(uint32_t number, const EmissionDraws& draws, EmittedRay& ray) const {
  const LightSetView::Punctual light = punctual_at(number, ray.time);
  ray.direction = light.axis;
  if (light.radius > 0.0f)
    ray.direction = -Frame::around(-light.axis).to_world(sample_even_cone(draws.direction, light.one_minus_cos));
  const V3f through = sample_disks(draws, ray.direction);
  ray.origin = through - ray.direction * reach;
  ray.density = punctual_density(number, through, ray.direction, ray.time);
  ray.finite_density = light.radius > 0.0f ? ray.density : ray.probability * disk_density(through, ray.direction);
}

void EmissionView::emit_from_environment(const EmissionDraws& draws, EmittedRay& ray) const {
  const LightSample sky = lights->environment.sample(draws.direction);
  if (!(sky.pdf > 0.0f) || !is_bright(sky.radiance)) return;
  ray.direction = -sky.wi;
  ray.radiance = sky.radiance;
  const V3f through = sample_disks(draws, ray.direction);
  ray.origin = through - ray.direction * reach;
  ray.density = ray.finite_density = environment_density({sky.radiance, sky.pdf}, through, ray.direction);
}

Rgb EmissionView::radiance(const EmittedRay& ray, const V3f& at) const {
  if (ray.emitter < lights->triangles.size() || ray.emitter == environment_emitter()) return ray.radiance;
  const LightSetView::Punctual light =
      punctual_at(ray.emitter - static_cast<uint32_t>(lights->triangles.size()), ray.time);
  const float per_size = light.radius > 0.0f ? kInvPi / square(light.radius) : 1.0f;
  if (light.kind == Kind::directional) return light.intensity * per_size;
  return light.intensity * lights->attenuated(light, -ray.direction, (light.position - at).length(), per_size);
}

} // namespace kindling
