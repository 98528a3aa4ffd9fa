// Samples of single lights: meshes, parallelograms, punctual lights and the environment.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/per_light_sampling.h"

#include "renderer/sampling/warp.h"

#include <algorithm>
#include <cassert>

namespace kindling {

bool PerLightView::is_delta(size_t light) const {
  return entries[light].kind == Kind::punctual && !(lights->punctuals[entries[light].first].radius > 0.0f);
}

PerLightView::OnTriangle PerLightView::choose_point(const Entry& entry, const V2f& u) const {
  if (entry.is_parallelogram) {
    const Parallelogram& p = entry.parallelogram;
    const bool first = u.x + u.y <= 1.0f;
    float weights[3];
    if (first) {
      weights[p.apex] = 1.0f - u.x - u.y;
      weights[p.s0] = u.x;
      weights[p.s1] = u.y;
    } else {
      weights[p.other] = u.x + u.y - 1.0f;
      weights[p.t0] = 1.0f - u.y;
      weights[p.t1] = 1.0f - u.x;
    }
    const uint32_t triangle = entry.first + (first ? 0 : 1);
    const float double_area = double_area_normal(lights->triangles[entry.first]).length();
    return {triangle, {weights[1], weights[2]}, 1.0f / double_area};
  }
  const double* begin = sums.data() + entry.first;
  const double* end = begin + entry.count;
  const double at = static_cast<double>(u.x) * end[-1];
  const double* found = std::min(std::upper_bound(begin, end, at), end - 1);
  const double before = found == begin ? 0.0 : found[-1];
  const double weight = *found - before;
  if (!(weight > 0.0)) return {};
  const auto rest = static_cast<float>(std::clamp((at - before) / weight, 0.0, 1.0));
  const uint32_t triangle = entry.first + static_cast<uint32_t>(found - begin);
  const double area = 0.5 * static_cast<double>(double_area_normal(lights->triangles[triangle]).length());
  return {triangle, sample_uniform_triangle(V2f(std::min(rest, kOneMinusEpsilon), u.y)),
          static_cast<float>(weight / (end[-1] * area))};
}

std::optional<LightSample> PerLightView::sample_mesh(const Entry& entry, const V3f& point, const V2f& u,
                                                     float time) const {
  OnTriangle at = choose_point(entry, u);
  if (!(at.pdf > 0.0f)) return std::nullopt;
  auto t = lights->triangles[at.triangle];
  if (lights->moves(at.triangle)) {
    const float first = double_area_normal(t).length();
    t = lights->posed_triangle(at.triangle, time);
    at.pdf *= first / double_area_normal(t).length();
  }
  const Emission& emission = lights->emissions[t.emission];
  const V3f normal = double_area_normal(t);
  const bool front = normal.dot(point - t.p0) > 0.0f;
  if (!front && !emission.two_sided) return std::nullopt;
  const V2f& b = at.barycentrics;
  const V3f to_light = t.p0 * (1.0f - b.x - b.y) + t.p1 * b.x + t.p2 * b.y - point;
  LightSample result;
  result.distance = std::sqrt(to_light.length2());
  result.wi = to_light * (1.0f / result.distance);
  result.normal = normal * ((front ? 1.0f : -1.0f) / normal.length());
  const float cosine = std::fabs(result.normal.dot(result.wi));
  result.pdf = at.pdf * square(result.distance) / cosine;
  result.radiance = lights->emission_at(at.triangle, b.x, b.y);
  result.radiance *= LightSetView::through_coat(emission, front, result.normal.dot(result.wi));
  return result;
}

std::optional<LightSample> PerLightView::sample(size_t light, const V3f& point, const V3f& normal, const V2f& u,
                                                float time) const {
  assert(light < entries.size());
  const Entry& entry = entries[light];
  std::optional<LightSample> result;
  switch (entry.kind) {
  case Kind::mesh: result = sample_mesh(entry, point, u, time); break;
  case Kind::punctual:
    result = lights->sample_punctual(entry.first, point, u, time);
    if (result && entry.first >= lights->first_directional) result->kind = LightKind::directional;
    break;
  case Kind::environment:
    result = lights->environment.sample(u);
    if (result) result->kind = LightKind::environment;
    break;
  }
  if (!result || !(result->pdf > 0.0f && result->pdf < kInfinity)) return std::nullopt;
  if (normal != V3f(0.0f) && !(result->wi.dot(normal) > 0.0f)) return std::nullopt;
  return result;
}

} // namespace kindling
