// Prepares a LightSet: how strongly each light shines, and the bounds that its tree wants.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_set.h"

#include "renderer/light/closed_shells.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>

namespace kindling {

namespace {

// Weight of the inner side of a closed body: it is hidden, unless another surface lives inside.
constexpr float kInnerSide = 1.0f / 16.0f;

// Of a light, only what is finite and positive counts.
float accepted(double intensity) {
  return intensity > 0.0 && std::isfinite(intensity) ? static_cast<float>(std::clamp(intensity, 1e-30, 1e30)) : 0.0f;
}

// A sphere around the centroid, wide enough for the rounding of differences of positions.
EmitterBounds triangle_bounds(const V3f& p0, const V3f& p1, const V3f& p2, const V3f& normal) {
  EmitterBounds result;
  result.center = (p0 + p1 + p2) * (1.0f / 3.0f);
  float radius2 = 0.0f;
  float largest = 0.0f;
  for (const V3f& p : {p0, p1, p2}) {
    radius2 = std::max(radius2, (p - result.center).length2());
    largest = std::max(largest, std::max(std::fabs(p.x), std::max(std::fabs(p.y), std::fabs(p.z))));
  }
  result.radius = std::sqrt(radius2) * (1.0f + 1e-6f) + largest * 4e-7f;
  result.axis = normal;
  return result;
}

} // namespace

LightSet::LightSet(LightSetInput input)
    : emissions_(std::move(input.emissions)), profiled_(std::move(input.profiled)), meshes_(std::move(input.meshes)),
      environment_(std::move(input.environment)) {
  assert(input.triangle_uvs.empty() || input.triangle_uvs.size() == 3 * input.triangles.size());
  if (environment_ && environment_->is_black()) environment_ = nullptr;

  triangles_.reserve(input.triangles.size());
  std::vector<bool> two_sided(input.triangles.size());
  bool textured = false;
  for (const EmissiveTriangle& t : input.triangles) {
    two_sided[triangles_.size()] = emissions_[t.emission].two_sided;
    triangles_.push_back({t.p0, t.emission, t.p1, t.p2});
    textured = textured || emissions_[t.emission].texture != nullptr;
  }
  if (textured) uvs_ = std::move(input.triangle_uvs);
  add_punctuals(input);

  std::vector<EmitterBounds> emitters(triangles_.size());
  const std::vector<OuterSide> outer = find_outer_sides(input.triangles, two_sided, input.scene_radius_m);
  tbb::parallel_for(
      tbb::blocked_range<size_t>(0, triangles_.size(), 256), [&](const tbb::blocked_range<size_t>& range) {
        for (size_t i = range.begin(); i < range.end(); ++i) {
          const Triangle& t = triangles_[i];
          const V3f normal = (t.p1 - t.p0).cross(t.p2 - t.p0);
          const double double_area = static_cast<double>(normal.length());
          if (!(double_area > 0.0) || !std::isfinite(double_area)) continue;
          emitters[i] = triangle_bounds(t.p0, t.p1, t.p2, normal * static_cast<float>(1.0 / double_area));
          emitters[i].intensity =
              accepted(0.5 * double_area * static_cast<double>(luminance(mean_emission(static_cast<uint32_t>(i)))));
          if (!two_sided[i]) continue;
          emitters[i].back = outer[i] == OuterSide::both ? 1.0f : kInnerSide;
          if (outer[i] == OuterSide::back) emitters[i].axis = -emitters[i].axis;
        }
      });
  for (size_t i = 0; i < first_directional_; ++i) emitters.push_back(punctual_bounds(punctuals_[i]));
  for (const EmitterBounds& e : emitters) light_count_ += e.intensity > 0.0f ? 1 : 0;
  tree_ = LightTree(emitters);

  size_t kinds = tree_.empty() ? 0 : 1;
  for (size_t i = first_directional_; i < punctuals_.size(); ++i) {
    kinds += punctuals_[i].luminance > 0.0f ? 2 : 0; // even one may be below the horizon
    light_count_ += punctuals_[i].luminance > 0.0f ? 1 : 0;
  }
  if (environment_) {
    // Half of a uniform sky of radiance L lights a plane by pi L; only what its density follows is to be shared out. An
    // environment of subnormal radiance is still there.
    const float total = luminance(environment_->total_radiance()) * environment_->sampled_share();
    environment_irradiance_ = std::clamp(0.25f * total, 1e-30f, 1e30f);
    ++kinds;
    ++light_count_;
  }
  single_kind_ = kinds <= 1;
}

void LightSet::add_punctuals(const LightSetInput& input) {
  for (const PointLight& light : input.points) {
    Punctual p{Punctual::Kind::point, light.position, V3f(0.0f), light.intensity};
    p.inverse_range = light.range_m && *light.range_m > 0.0f ? 1.0f / *light.range_m : 0.0f;
    punctuals_.push_back(p);
    punctual_names_.push_back(light.name);
  }
  for (const SpotLight& light : input.spots) {
    Punctual p{Punctual::Kind::spot, light.position, light.axis, light.intensity};
    p.inverse_range = light.range_m && *light.range_m > 0.0f ? 1.0f / *light.range_m : 0.0f;
    p.angle_scale = 1.0f / std::max(0.001f, light.cos_inner - light.cos_outer);
    p.angle_offset = -light.cos_outer * p.angle_scale;
    punctuals_.push_back(p);
    punctual_names_.push_back(light.name);
  }
  for (const ProfiledLight& light : profiled_) {
    punctuals_.push_back({Punctual::Kind::profiled, light.position, V3f(0.0f), light.intensity});
    punctuals_.back().profiled = static_cast<uint32_t>(&light - profiled_.data());
    punctual_names_.push_back(light.name);
  }
  first_directional_ = punctuals_.size();
  for (const DirectionalLight& light : input.directionals) {
    punctuals_.push_back({Punctual::Kind::directional, V3f(0.0f), light.direction, light.irradiance});
    punctual_names_.push_back(light.name);
  }
  for (Punctual& p : punctuals_) {
    const float factor = p.kind == Punctual::Kind::profiled ? profiled_[p.profiled].profile->typical_intensity() : 1.0f;
    p.luminance = accepted(static_cast<double>(luminance(p.intensity)) * static_cast<double>(factor));
  }
}

EmitterBounds LightSet::punctual_bounds(const Punctual& light) {
  EmitterBounds result;
  result.center = light.position;
  result.radius =
      4e-7f * max_component({std::fabs(light.position.x), std::fabs(light.position.y), std::fabs(light.position.z)});
  result.intensity = is_finite(light.position) ? light.luminance : 0.0f;
  result.cos_normals = -1.0f;
  if (light.kind == Punctual::Kind::spot) {
    // Full inside of the cone and nothing beyond: the normals fill the cone and shine straight on.
    result.axis = light.axis;
    result.cos_normals = std::clamp(-light.angle_offset / light.angle_scale - 1e-5f, -1.0f, 1.0f);
    result.cos_emission = 1.0f - 1e-4f;
  }
  return result;
}

Rgb LightSet::mean_emission(uint32_t index) const {
  const Emission& emission = emissions_[triangles_[index].emission];
  if (emission.texture == nullptr || uvs_.empty()) return emission.factor;
  // A grid as fine as the texels that the triangle covers, between 2 and 32 steps along an edge. What it misses is not
  // lost: light that is never sampled is found by rays that happen to hit it.
  const V2f* uv = uvs_.data() + size_t{index} * 3;
  const V2f size(emission.texture->size_px());
  const float longest = std::max(((uv[1] - uv[0]) * size).length(),
                                 std::max(((uv[2] - uv[1]) * size).length(), ((uv[0] - uv[2]) * size).length()));
  const int steps = longest < 32.0f ? std::max(static_cast<int>(longest), 2) : 32; // NaN: 32
  V3d sum(0.0);
  int count = 0;
  for (int i = 0; i < steps; ++i) {
    for (int j = 0; j < steps - i; ++j) {
      // Centroids of the small triangles, upright and (but for the last of a row) inverted.
      const float third = 1.0f / (3.0f * static_cast<float>(steps));
      sum += V3d(emission_at(index, static_cast<float>(3 * i + 1) * third, static_cast<float>(3 * j + 1) * third));
      ++count;
      if (j + 1 >= steps - i) continue;
      sum += V3d(emission_at(index, static_cast<float>(3 * i + 2) * third, static_cast<float>(3 * j + 2) * third));
      ++count;
    }
  }
  sum /= static_cast<double>(count);
  return {static_cast<float>(sum.x), static_cast<float>(sum.y), static_cast<float>(sum.z)};
}

size_t LightSet::memory_bytes() const {
  return sizeof(*this) + emissions_.size() * sizeof(Emission) + triangles_.size() * sizeof(Triangle) +
         uvs_.size() * sizeof(V2f) + meshes_.size() * sizeof(EmissiveMesh) +
         punctuals_.size() * (sizeof(Punctual) + sizeof(std::string)) + tree_.memory_bytes() +
         (environment_ ? environment_->memory_bytes() : 0);
}

} // namespace kindling
