// Prepares a LightSet: the power of each light, and the bounds for its tree.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_set.h"

#include "renderer/base/elementary.h"
#include "renderer/base/huge_pages.h"
#include "renderer/light/closed_shells.h"
#include "renderer/light/cone_of_axes.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <utility>

namespace kindling {

namespace {

// Weight of the inner side of a closed body: it is hidden, unless another surface is inside.
constexpr float kInnerSide = 1.0f / 16.0f;

// Returns the intensity if it is finite and positive, clamped, else 0.
float accepted(double intensity) {
  return intensity > 0.0 && std::isfinite(intensity) ? static_cast<float>(std::clamp(intensity, 1e-30, 1e30)) : 0.0f;
}

// Returns the size in meters or radians, or 0 if it is too small or invalid.
float accepted_size(float size) { return size > 1e-6f && size < 1e15f ? size : 0.0f; }

// Returns a bounding sphere around the centroid, with a margin for the rounding of position
// differences.
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

LightSet::LightSet(LightSetInput input) : meshes_(std::move(input.meshes)) {
  assert(input.triangle_uvs.empty() || input.triangle_uvs.size() == 3 * input.triangles.size());
  HugePageVector<Triangle> corners;
  corners.reserve(input.triangles.size());
  std::vector<bool> two_sided(input.triangles.size());
  bool textured = false;
  for (const EmissiveTriangle& t : input.triangles) {
    two_sided[corners.size()] = input.emissions[t.emission].two_sided;
    corners.push_back({t.p0, t.emission, t.p1, t.p2});
    textured = textured || input.emissions[t.emission].texture != nullptr;
  }
  triangles = arrays_.keep(std::move(corners));
  emissions = arrays_.keep(std::move(input.emissions));
  if (textured) uvs = arrays_.keep(std::move(input.triangle_uvs));
  moving = arrays_.keep(std::move(input.moving));
  later_corners = arrays_.keep(std::move(input.later_corners));
  first_moving = static_cast<uint32_t>(triangles.size() - moving.size());
  add_punctuals(input);

  std::vector<EmitterBounds> emitters(triangles.size());
  const std::vector<OuterSide> outer = find_outer_sides(input.triangles, two_sided, input.scene_radius_m);
  tbb::parallel_for(tbb::blocked_range<size_t>(0, triangles.size(), 256), [&](const tbb::blocked_range<size_t>& range) {
    for (size_t i = range.begin(); i < range.end(); ++i) {
      if (moves(static_cast<uint32_t>(i))) {
        emitters[i] = moving_bounds(static_cast<uint32_t>(i));
        emitters[i].intensity = accepted(static_cast<double>(emitters[i].intensity));
        emitters[i].back = two_sided[i] ? 1.0f : 0.0f;
        continue;
      }
      const Triangle& t = triangles[i];
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
  for (size_t i = 0; i < first_directional; ++i) emitters.push_back(punctual_bounds(punctuals[i]));
  for (const EmitterBounds& e : emitters) light_count += e.intensity > 0.0f ? 1 : 0;
  stored_tree_ = LightTree(emitters);
  tree = stored_tree_;

  kind_count_ = tree.empty() ? 0 : 1;
  for (size_t i = first_directional; i < punctuals.size(); ++i) {
    kind_count_ += punctuals[i].luminance > 0.0f ? 2 : 0; // even a single one may be below the horizon
    light_count += punctuals[i].luminance > 0.0f ? 1 : 0;
  }
  set_environment(std::move(input.environment));
}

void LightSet::set_environment(std::shared_ptr<const Environment> light) {
  if (has_environment) {
    --kind_count_;
    --light_count;
    environment_irradiance = 0.0f;
  }
  stored_environment_ = light && !light->is_black() ? std::move(light) : nullptr;
  has_environment = stored_environment_ != nullptr;
  environment = has_environment ? EnvironmentView(*stored_environment_) : EnvironmentView();
  if (has_environment) {
    // Half of a uniform sky of radiance L lights a plane by pi L; only the fraction that its
    // density follows counts. An environment of subnormal radiance still counts as present.
    const float total = luminance(environment.total_radiance) * stored_environment_->sampled_fraction();
    environment_irradiance = std::clamp(0.25f * total, 1e-30f, 1e30f);
    ++kind_count_;
    ++light_count;
  }
  single_kind = kind_count_ <= 1;
}

void LightSet::add_punctuals(const LightSetInput& input) {
  std::vector<Punctual> lights;
  std::vector<LightFrame> keys;
  // `light` has all properties of its kind except for the frame.
  const auto add = [&](Punctual light, const auto& input_light, const LightFrame& first) {
    const std::vector<LightFrame>& later = input_light.later;
    if (!later.empty()) {
      light.key_count = static_cast<uint32_t>(1 + later.size());
      light.first_key = static_cast<uint32_t>(keys.size());
      keys.push_back(first);
      keys.insert(keys.end(), later.begin(), later.end());
    }
    lights.push_back(light);
    punctual_names_.push_back(input_light.name);
    punctual_sources_.push_back(input_light.source);
  };
  const auto inverse = [](const std::optional<float>& range_m) {
    return range_m && *range_m > 0.0f ? 1.0f / *range_m : 0.0f;
  };
  for (const PointLight& light : input.points) {
    Punctual p{Punctual::Kind::point, light.position, V3f(0.0f), light.intensity};
    p.inverse_range = inverse(light.range_m);
    p.radius = accepted_size(light.radius_m);
    add(p, light, {light.position});
  }
  for (const SpotLight& light : input.spots) {
    Punctual p{Punctual::Kind::spot, light.position, light.axis, light.intensity};
    p.inverse_range = inverse(light.range_m);
    p.angle_scale = 1.0f / std::max(0.001f, light.cos_inner - light.cos_outer);
    p.angle_offset = -light.cos_outer * p.angle_scale;
    p.radius = accepted_size(light.radius_m);
    LightFrame frame{light.position};
    frame.z = -light.axis;
    add(p, light, frame);
  }
  std::vector<LightProfileView> webs;
  for (const ProfiledLight& light : input.profiled) {
    Punctual p{Punctual::Kind::profiled, light.position, -light.axes[2], light.intensity};
    p.profiled = static_cast<uint32_t>(webs.size());
    p.radius = accepted_size(light.radius_m);
    p.x = light.axes[0];
    p.y = light.axes[1];
    add(p, light, {light.position, light.axes[0], light.axes[1], light.axes[2]});
    webs.push_back(*light.profile);
    arrays_.share(light.profile);
  }
  first_directional = lights.size();
  for (const DirectionalLight& light : input.directionals) {
    Punctual p{Punctual::Kind::directional, V3f(0.0f), light.direction, light.irradiance};
    const float half = 0.5f * accepted_size(std::min(light.angular_diameter_rad, kPi));
    p.radius = half > 0.0f ? elementary::sin(half) : 0.0f;
    p.one_minus_cos = 2.0f * square(elementary::sin(0.5f * half));
    LightFrame frame;
    frame.z = -light.direction;
    add(p, light, frame);
  }
  for (Punctual& p : lights) {
    const float factor =
        p.kind == Punctual::Kind::profiled ? input.profiled[p.profiled].profile->typical_intensity() : 1.0f;
    p.luminance = accepted(static_cast<double>(luminance(p.intensity)) * static_cast<double>(factor));
  }
  profiles = arrays_.keep(std::move(webs));
  frames = arrays_.keep(std::move(keys));
  prepare_shapes(lights);
  punctuals = arrays_.keep(std::move(lights));
}

// Prepares the shapes that rays can hit, and the reach of directional lights.
void LightSet::prepare_shapes(std::span<Punctual> lights) {
  std::vector<SphereTree::Sphere> bodies;
  std::vector<uint32_t> in_the_sky;
  for (uint32_t i = 0; i < lights.size(); ++i) {
    Punctual& p = lights[i];
    const bool in_sky = i >= first_directional;
    const auto keys = frames.subspan(p.first_key, p.key_count);
    if (in_sky && (p.radius > 0.0f || !keys.empty())) {
      const Cone swept = cone_of_axes(-p.axis, keys);
      p.sin_reach = elementary::sin(std::min(swept.angle + elementary::asin(std::min(p.radius, 1.0f)), 0.5f * kPi));
      p.axis = -swept.axis;
    }
    if (!(p.radius > 0.0f && p.luminance > 0.0f)) continue;
    if (in_sky) {
      in_the_sky.push_back(i);
      continue;
    }
    const EmitterBounds bounds = punctual_bounds(p);
    if (bounds.intensity > 0.0f) bodies.push_back({bounds.center, bounds.radius, i});
  }
  stored_spheres_ = SphereTree(std::move(bodies));
  spheres = stored_spheres_;
  disks = arrays_.keep(std::move(in_the_sky));
  has_shapes = !spheres.empty() || !disks.empty();
}

size_t LightSet::memory_bytes() const {
  return sizeof(*this) + arrays_.bytes() + meshes_.size() * sizeof(EmissiveMesh) +
         punctual_names_.size() * (sizeof(std::string) + sizeof(uint32_t)) + stored_spheres_.memory_bytes() +
         stored_tree_.memory_bytes() + (stored_environment_ ? stored_environment_->memory_bytes() : 0);
}

} // namespace kindling
