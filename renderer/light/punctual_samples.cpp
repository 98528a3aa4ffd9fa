// Point, spot and directional lights: sampling, and intersection of sized ones with rays.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_set_view.h"

#include "renderer/base/elementary.h"
#include "renderer/light/sphere_seen.h"
#include "renderer/sampling/mis.h"

namespace kindling {

std::optional<LightSample> LightSetView::sample_punctual(uint32_t number, const V3f& point, const V2f& u,
                                                         float time) const {
  const Punctual& light = punctuals[number];
  return light.key_count == 0 ? sample_posed(light, point, u) : sample_posed(posed(light, time), point, u);
}

LightSetView::Punctual LightSetView::posed(const Punctual& light, float time) const {
  const LightFrame frame = frame_at({frames.data() + light.first_key, light.key_count}, time);
  Punctual result = light;
  result.position = frame.position;
  result.axis = -frame.z;
  result.x = frame.x;
  result.y = frame.y;
  return result;
}

float LightSetView::attenuated(const Punctual& light, const V3f& wi, float distance, float scale) const {
  if (light.inverse_range > 0.0f) {
    // KHR_lights_punctual, "Range Property": max(min(1 - (distance / range)^4, 1), 0) / distance^2.
    scale *= std::clamp(1.0f - square(square(distance * light.inverse_range)), 0.0f, 1.0f);
  }
  if (light.kind == Punctual::Kind::spot) {
    // KHR_lights_punctual, "Inner and Outer Cone Angles".
    scale *= square(std::clamp(-light.axis.dot(wi) * light.angle_scale + light.angle_offset, 0.0f, 1.0f));
  }
  if (light.kind == Punctual::Kind::profiled) {
    scale *= profiles[light.profiled].intensity(-V3f(wi.dot(light.x), wi.dot(light.y), -wi.dot(light.axis)));
  }
  return scale;
}

std::optional<LightSample> LightSetView::sample_posed(const Punctual& light, const V3f& point, const V2f& u) const {
  LightSample result;
  if (light.kind == Punctual::Kind::directional) {
    result.distance = kInfinity;
    if (light.radius > 0.0f) {
      result.wi = Frame::around(-light.axis).to_world(sample_even_cone(u, light.one_minus_cos));
      result.pdf = 0.5f * kInvPi / light.one_minus_cos;
      result.radiance = light.intensity * (kInvPi / square(light.radius));
      return result;
    }
    result.delta = true;
    result.pdf = 1.0f;
    result.wi = -light.axis;
    result.radiance = light.intensity;
    return result;
  }
  const V3f to_light = light.position - point;
  const float distance2 = to_light.length2();
  if (light.radius > 0.0f) {
    const SphereSeen sphere(to_light, light.radius);
    result.wi = sphere.sample(u);
    result.distance = sphere.sampled_distance(result.wi);
    result.pdf = sphere.pdf();
    const float attenuation = attenuated(light, result.wi, std::sqrt(distance2), kInvPi / square(light.radius));
    if (!(attenuation > 0.0f)) return std::nullopt;
    result.radiance = light.intensity * attenuation;
    return result;
  }
  if (!(distance2 > 0.0f)) return std::nullopt;
  result.delta = true;
  result.pdf = 1.0f;
  result.distance = std::sqrt(distance2);
  result.wi = to_light * (1.0f / result.distance);
  const float attenuation = attenuated(light, result.wi, result.distance, 1.0f / distance2);
  if (!(attenuation > 0.0f)) return std::nullopt;
  result.radiance = light.intensity * attenuation;
  return result;
}

Rgb LightSetView::shape_radiance(const ShapeRay& ray) const {
  Rgb sum(0.0f);
  spheres.visit(ray.origin, ray.direction, ray.end_m, [&](uint32_t number) { add_sphere(number, ray, sum); });
  if (ray.end_m == kInfinity)
    for (const uint32_t number : disks) add_disk(number, ray, sum);
  return sum;
}

void LightSetView::add_sphere(uint32_t number, const ShapeRay& ray, Rgb& sum) const {
  const Punctual light = punctuals[number].key_count == 0 ? punctuals[number] : posed(punctuals[number], ray.time);
  const V3f to_center = light.position - ray.origin;
  const SphereSeen sphere(to_center, light.radius);
  const std::optional<float> distance = sphere.distance(ray.direction);
  if (!distance || *distance < ray.begin_m || !(*distance < ray.end_m)) return;
  const float attenuation = attenuated(light, ray.direction, to_center.length(), kInvPi / square(light.radius));
  if (!(attenuation > 0.0f)) return;
  float weight = 1.0f;
  if (ray.bsdf_pdf > 0.0f) {
    const auto emitter = static_cast<uint32_t>(triangles.size()) + number;
    const float probability =
        tree.probability(emitter, ray.origin, ray.normal) * tree_probability(ray.origin, ray.normal, ray.learned);
    weight = power_heuristic(ray.bsdf_pdf, sphere.pdf() * probability);
  }
  Rgb radiance = light.intensity * (weight * attenuation);
  const float depth = *distance - ray.begin_m;
  for (int c = 0; c < 3; ++c)
    if (ray.extinction[c] > 0.0f) radiance[c] *= elementary::exp(-ray.extinction[c] * depth);
  sum += radiance;
}

void LightSetView::add_disk(uint32_t number, const ShapeRay& ray, Rgb& sum) const {
  const Punctual& light = punctuals[number];
  const V3f axis = light.key_count == 0 ? light.axis : posed(light, ray.time).axis;
  // |wi + axis|^2 = 2 (1 - cos), which keeps the digits of small angles.
  if ((ray.direction + axis).length2() > 2.0f * light.one_minus_cos) return;
  float weight = 1.0f;
  if (ray.bsdf_pdf > 0.0f) {
    const SelectionWeights all = selection_weights(ray.origin, ray.normal, ray.learned);
    const float selection_weight = light_selection_weight(directional_irradiance(light, ray.normal), all.strongest);
    weight = power_heuristic(ray.bsdf_pdf, all.sum > 0.0f ? selection_weight * all.directional_scale / all.sum *
                                                                (0.5f * kInvPi / light.one_minus_cos)
                                                          : 0.0f);
  }
  sum += light.intensity * (weight * kInvPi / square(light.radius));
}

} // namespace kindling
