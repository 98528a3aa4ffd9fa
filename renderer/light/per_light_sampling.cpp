// Sampling of single lights: meshes, parallelograms, punctual lights and the environment.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/per_light_sampling.h"

#include "renderer/sampling/warp.h"

#include <algorithm>
#include <cassert>

namespace kindling {

namespace {

template <typename Triangle>
const V3f& corner(const Triangle& t, int i) {
  return i == 0 ? t.p0 : i == 1 ? t.p1 : t.p2;
}

} // namespace

PerLightSampling::PerLightSampling(const LightSet& lights) : lights_(lights) {
  sums_.resize(lights.triangles.size());
  for (const EmissiveMesh& mesh : lights.meshes_) add_mesh(mesh, static_cast<uint32_t>(&mesh - lights.meshes_.data()));
  for (size_t i = 0; i < lights.punctuals.size(); ++i)
    if (lights.punctuals[i].luminance > 0.0f)
      entries_.push_back({.kind = Kind::punctual, .first = static_cast<uint32_t>(i)});
  if (lights.has_environment) entries_.push_back({.kind = Kind::environment});
}

void PerLightSampling::add_mesh(const EmissiveMesh& mesh, uint32_t number) {
  double sum = 0.0;
  for (uint32_t i = mesh.first; i < mesh.first + mesh.count; ++i) {
    const double weight = static_cast<double>(double_area_normal(lights_.triangles[i]).length()) *
                          static_cast<double>(luminance(lights_.mean_emission(i)));
    if (weight > 0.0 && std::isfinite(weight)) sum += weight;
    sums_[i] = sum;
  }
  if (!(sum > 0.0)) return;
  Entry entry{.kind = Kind::mesh, .first = mesh.first, .count = mesh.count, .name = number};
  if (mesh.count == 2 && lights_.triangles[mesh.first].emission == lights_.triangles[mesh.first + 1].emission) {
    const auto& a = lights_.triangles[mesh.first];
    const auto& b = lights_.triangles[mesh.first + 1];
    const float size = std::sqrt(double_area_normal(a).length());
    const bool same_side = double_area_normal(a).dot(double_area_normal(b)) > 0.0f;
    for (int apex = 0; apex < 3 && same_side; ++apex) {
      const int s0 = (apex + 1) % 3, s1 = (apex + 2) % 3;
      const V3f opposite = corner(a, s0) + corner(a, s1) - corner(a, apex);
      for (int other = 0; other < 3; ++other) {
        // The winding is equal, so the shared side runs in the opposite direction.
        const int t0 = (other + 2) % 3, t1 = (other + 1) % 3;
        if (corner(a, s0) != corner(b, t0) || corner(a, s1) != corner(b, t1)) continue;
        if ((corner(b, other) - opposite).length() > 1e-5f * size || lights_.moves(mesh.first)) continue;
        entry.is_parallelogram = true;
        entry.parallelogram = {static_cast<uint8_t>(apex), static_cast<uint8_t>(s0), static_cast<uint8_t>(s1),
                               static_cast<uint8_t>(t0),   static_cast<uint8_t>(t1), static_cast<uint8_t>(other)};
      }
    }
  }
  entries_.push_back(entry);
}

std::string_view PerLightSampling::name(size_t light) const {
  assert(light < entries_.size());
  const Entry& entry = entries_[light];
  switch (entry.kind) {
  case Kind::mesh: return lights_.meshes_[entry.name].name;
  case Kind::punctual: return lights_.punctual_names_[entry.first];
  case Kind::environment: break;
  }
  return "environment";
}

bool PerLightSampling::is_delta(size_t light) const {
  return entries_[light].kind == Kind::punctual && !(lights_.punctuals[entries_[light].first].radius > 0.0f);
}

PerLightSampling::OnTriangle PerLightSampling::choose_point(const Entry& entry, const V2f& u) const {
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
    const float double_area = double_area_normal(lights_.triangles[entry.first]).length();
    return {triangle, {weights[1], weights[2]}, 1.0f / double_area};
  }
  const double* begin = sums_.data() + entry.first;
  const double* end = begin + entry.count;
  const double at = static_cast<double>(u.x) * end[-1];
  const double* found = std::min(std::upper_bound(begin, end, at), end - 1);
  const double before = found == begin ? 0.0 : found[-1];
  const double weight = *found - before;
  if (!(weight > 0.0)) return {};
  const auto rest = static_cast<float>(std::clamp((at - before) / weight, 0.0, 1.0));
  const uint32_t triangle = entry.first + static_cast<uint32_t>(found - begin);
  const double area = 0.5 * static_cast<double>(double_area_normal(lights_.triangles[triangle]).length());
  return {triangle, sample_uniform_triangle({std::min(rest, kOneMinusEpsilon), u.y}),
          static_cast<float>(weight / (end[-1] * area))};
}

std::optional<LightSample> PerLightSampling::sample_mesh(const Entry& entry, const V3f& point, const V2f& u,
                                                         float time) const {
  OnTriangle at = choose_point(entry, u);
  if (!(at.pdf > 0.0f)) return std::nullopt;
  auto t = lights_.triangles[at.triangle];
  if (lights_.moves(at.triangle)) {
    const float first = double_area_normal(t).length();
    t = lights_.posed_triangle(at.triangle, time);
    at.pdf *= first / double_area_normal(t).length();
  }
  const Emission& emission = lights_.emissions[t.emission];
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
  result.radiance = lights_.emission_at(at.triangle, b.x, b.y);
  result.radiance *= LightSet::through_coat(emission, front, result.normal.dot(result.wi));
  return result;
}

std::optional<LightSample> PerLightSampling::sample(size_t light, const V3f& point, const V3f& normal, const V2f& u,
                                                    float time) const {
  assert(light < entries_.size());
  const Entry& entry = entries_[light];
  std::optional<LightSample> result;
  switch (entry.kind) {
  case Kind::mesh: result = sample_mesh(entry, point, u, time); break;
  case Kind::punctual:
    result = lights_.sample_punctual(entry.first, point, u, time);
    if (result && entry.first >= lights_.first_directional) result->kind = LightKind::directional;
    break;
  case Kind::environment:
    result = lights_.environment.sample(u);
    if (result) result->kind = LightKind::environment;
    break;
  }
  if (!result || !(result->pdf > 0.0f && result->pdf < kInfinity)) return std::nullopt;
  if (normal != V3f(0.0f) && !(result->wi.dot(normal) > 0.0f)) return std::nullopt;
  return result;
}

} // namespace kindling
