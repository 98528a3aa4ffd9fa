// Choosing a light, sampling it, and saying how likely that was.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_set.h"

#include "renderer/sampling/quantized_cdf.h"
#include "renderer/sampling/warp.h"

namespace kindling {

namespace {

// Seen from farther than this many longest edges, distance and angle hardly vary over a triangle: by area is as good
// and cheaper.
constexpr float kFarInEdges = 2.0f;

template <typename Triangle>
bool sampled_by_solid_angle(const Triangle& t, const V3f& point) {
  const V3f to_centroid = (t.p0 + t.p1 + t.p2) * (1.0f / 3.0f) - point;
  const float longest2 = std::max((t.p1 - t.p0).length2(), std::max((t.p2 - t.p1).length2(), (t.p0 - t.p2).length2()));
  return to_centroid.length2() < square(kFarInEdges) * longest2;
}

// Length: twice the area. Points to the side from which p0, p1, p2 are counter-clockwise.
template <typename Triangle>
V3f double_area_normal(const Triangle& t) {
  return (t.p1 - t.p0).cross(t.p2 - t.p0);
}

// Density by solid angle of a point that is uniform by area.
float area_density(const V3f& double_area_normal, const V3f& wi, float distance) {
  const float projected = 0.5f * std::fabs(double_area_normal.dot(wi));
  return projected > 0.0f ? square(distance) / projected : 0.0f;
}

} // namespace

std::optional<LightSample> LightSet::sample(const V3f& point, const V3f& /*normal*/, float u_light,
                                            const V2f& u) const {
  if (empty()) return std::nullopt;
  const Chosen chosen = choose(u_light, u);
  if (chosen.light < triangles_.size()) return sample_triangle(chosen.light, point, chosen.u);
  const size_t other = chosen.light - triangles_.size();
  if (other < punctuals_.size()) return sample_punctual(punctuals_[other], point);
  LightSample result = environment_->sample(chosen.u);
  result.pdf *= environment_probability_;
  if (!(result.pdf > 0.0f)) return std::nullopt;
  return result;
}

LightSet::Chosen LightSet::choose(float u_light, const V2f& u) const {
  const uint32_t cell = find_cdf_cell(cdf_.data(), guide_.data(), guide_size_, u_light);
  if (run_shift_ == 0) return {cell, u};
  // Among the lights of a run u.x decides, and is stretched again.
  const float cell_probability = cdf_[cell + 1] - cdf_[cell];
  const auto end = static_cast<uint32_t>(
      std::min(size_t{cell + 1} << run_shift_, triangles_.size() + punctuals_.size() + (environment_ ? 1 : 0)));
  uint32_t light = cell << run_shift_;
  float rest = u.x * cell_probability;
  uint32_t last = light;
  for (; light < end; ++light) {
    const float p = probability(light);
    if (p <= 0.0f) continue;
    last = light;
    if (rest < p) break;
    rest -= p;
  }
  return {last, {std::min(rest / probability(last), kOneMinusEpsilon), u.y}};
}

float LightSet::probability(uint32_t light) const {
  if (light < triangles_.size()) return triangles_[light].probability;
  const size_t other = light - triangles_.size();
  return other < punctuals_.size() ? punctuals_[other].probability : environment_probability_;
}

std::optional<LightSample> LightSet::sample_triangle(uint32_t index, const V3f& point, const V2f& u) const {
  const Triangle& t = triangles_[index];
  const V3f normal = double_area_normal(t);
  const bool front = normal.dot(point - t.p0) > 0.0f;
  if (!front && !emissions_[t.emission].two_sided) return std::nullopt;

  LightSample result;
  V2f barycentrics;
  if (sampled_by_solid_angle(t, point)) {
    const SphericalTriangle seen(t.p0, t.p1, t.p2, point);
    result.pdf = seen.pdf() * t.probability;
    if (!(result.pdf > 0.0f)) return std::nullopt;
    const SphericalTriangle::Sample sample = seen.sample(u);
    barycentrics = sample.barycentrics;
    const V3f on_light =
        t.p0 * (1.0f - barycentrics.x - barycentrics.y) + t.p1 * barycentrics.x + t.p2 * barycentrics.y;
    result.wi = sample.direction;
    result.distance = (on_light - point).length();
  } else {
    barycentrics = sample_uniform_triangle(u);
    const V3f on_light =
        t.p0 * (1.0f - barycentrics.x - barycentrics.y) + t.p1 * barycentrics.x + t.p2 * barycentrics.y;
    const V3f to_light = on_light - point;
    result.distance = to_light.length();
    result.wi = to_light * (1.0f / result.distance);
    result.pdf = area_density(normal, result.wi, result.distance) * t.probability;
  }
  if (!(result.pdf > 0.0f && result.pdf < kInfinity)) return std::nullopt;
  result.radiance = emission_at(index, barycentrics.x, barycentrics.y);
  result.normal = normal * ((front ? 1.0f : -1.0f) / normal.length());
  return result;
}

float LightSet::pdf_triangle(uint32_t triangle, const V3f& point, const V3f& wi, float distance) const {
  const Triangle& t = triangles_[triangle];
  if (!(t.probability > 0.0f)) return 0.0f;
  const float density = sampled_by_solid_angle(t, point) ? SphericalTriangle(t.p0, t.p1, t.p2, point).pdf()
                                                         : area_density(double_area_normal(t), wi, distance);
  return density < kInfinity ? density * t.probability : 0.0f;
}

std::optional<LightSample> LightSet::sample_punctual(const Punctual& light, const V3f& point) {
  LightSample result;
  result.delta = true;
  result.pdf = light.probability;
  if (light.kind == Punctual::Kind::directional) {
    result.wi = -light.axis;
    result.distance = kInfinity;
    result.radiance = light.intensity;
    return result;
  }
  const V3f to_light = light.position - point;
  const float distance2 = to_light.length2();
  if (!(distance2 > 0.0f)) return std::nullopt;
  result.distance = std::sqrt(distance2);
  result.wi = to_light * (1.0f / result.distance);
  float attenuation = 1.0f / distance2;
  if (light.inverse_range > 0.0f) {
    // KHR_lights_punctual, "Range Property": max(min(1 - (distance / range)^4, 1), 0) / distance^2.
    attenuation *= std::clamp(1.0f - square(square(result.distance * light.inverse_range)), 0.0f, 1.0f);
  }
  if (light.kind == Punctual::Kind::spot) {
    // KHR_lights_punctual, "Inner and Outer Cone Angles".
    attenuation *= square(std::clamp(-light.axis.dot(result.wi) * light.angle_scale + light.angle_offset, 0.0f, 1.0f));
  }
  if (!(attenuation > 0.0f)) return std::nullopt;
  result.radiance = light.intensity * attenuation;
  return result;
}

Rgb LightSet::emission_at(uint32_t index, float u, float v) const {
  const Emission& emission = emissions_[triangles_[index].emission];
  if (emission.texture == nullptr || uvs_.empty()) return emission.factor;
  const V2f* uv = uvs_.data() + size_t{index} * 3;
  return emission.factor * emission.texture->sample_rgb(uv[0] * (1.0f - u - v) + uv[1] * u + uv[2] * v);
}

Rgb LightSet::emitted(uint32_t triangle, float u, float v, const V3f& wi) const {
  const Triangle& t = triangles_[triangle];
  if (!emissions_[t.emission].two_sided && !(double_area_normal(t).dot(wi) < 0.0f)) return Rgb(0.0f);
  return emission_at(triangle, u, v);
}

} // namespace kindling
