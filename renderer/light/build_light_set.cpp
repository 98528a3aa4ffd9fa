// Prepares a LightSet: the power of each light, and the bounds for its tree.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_set.h"

#include "renderer/base/elementary.h"
#include "renderer/light/closed_shells.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>

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

// A cone that contains the z axes of all frames and of the interpolation between them.
struct Cone {
  V3f axis; // unit
  float angle = 0.0f;
};
Cone cone_of_axes(const V3f& first_axis, std::span<const LightFrame> frames) {
  if (frames.empty()) return {first_axis, 0.0f};
  V3f sum(0.0f);
  for (const LightFrame& frame : frames) sum += frame.z;
  Cone result{sum.length() > 1e-3f ? sum.normalized() : first_axis, 0.0f};
  for (const LightFrame& frame : frames)
    result.angle = std::max(result.angle, elementary::acos(std::clamp(frame.z.dot(result.axis), -1.0f, 1.0f)) + 1e-3f);
  if (!(result.angle < 0.5f * kPi)) result.angle = kPi; // caps are convex up to half of the sphere
  return result;
}

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

LightSet::LightSet(LightSetInput input)
    : emissions_(std::move(input.emissions)), profiled_(std::move(input.profiled)), meshes_(std::move(input.meshes)) {
  assert(input.triangle_uvs.empty() || input.triangle_uvs.size() == 3 * input.triangles.size());
  triangles_.reserve(input.triangles.size());
  std::vector<bool> two_sided(input.triangles.size());
  bool textured = false;
  for (const EmissiveTriangle& t : input.triangles) {
    two_sided[triangles_.size()] = emissions_[t.emission].two_sided;
    triangles_.push_back({t.p0, t.emission, t.p1, t.p2});
    textured = textured || emissions_[t.emission].texture != nullptr;
  }
  if (textured) uvs_ = std::move(input.triangle_uvs);
  moving_ = std::move(input.moving);
  later_corners_ = std::move(input.later_corners);
  first_moving_ = static_cast<uint32_t>(triangles_.size() - moving_.size());
  add_punctuals(input);

  std::vector<EmitterBounds> emitters(triangles_.size());
  const std::vector<OuterSide> outer = find_outer_sides(input.triangles, two_sided, input.scene_radius_m);
  tbb::parallel_for(
      tbb::blocked_range<size_t>(0, triangles_.size(), 256), [&](const tbb::blocked_range<size_t>& range) {
        for (size_t i = range.begin(); i < range.end(); ++i) {
          if (moves(static_cast<uint32_t>(i))) {
            emitters[i] = moving_bounds(static_cast<uint32_t>(i));
            emitters[i].intensity = accepted(static_cast<double>(emitters[i].intensity));
            emitters[i].back = two_sided[i] ? 1.0f : 0.0f;
            continue;
          }
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

  kind_count_ = tree_.empty() ? 0 : 1;
  for (size_t i = first_directional_; i < punctuals_.size(); ++i) {
    kind_count_ += punctuals_[i].luminance > 0.0f ? 2 : 0; // even a single one may be below the horizon
    light_count_ += punctuals_[i].luminance > 0.0f ? 1 : 0;
  }
  set_environment(std::move(input.environment));
}

void LightSet::set_environment(std::shared_ptr<const Environment> environment) {
  if (environment_) {
    --kind_count_;
    --light_count_;
    environment_irradiance_ = 0.0f;
  }
  environment_ = environment && !environment->is_black() ? std::move(environment) : nullptr;
  if (environment_) {
    // Half of a uniform sky of radiance L lights a plane by pi L; only the fraction that its
    // density follows counts. An environment of subnormal radiance still counts as present.
    const float total = luminance(environment_->total_radiance()) * environment_->sampled_fraction();
    environment_irradiance_ = std::clamp(0.25f * total, 1e-30f, 1e30f);
    ++kind_count_;
    ++light_count_;
  }
  single_kind_ = kind_count_ <= 1;
}

// `light` has all properties of its kind except for the frame.
void LightSet::add_punctual(Punctual light, const std::string& name, const LightFrame& first,
                            const std::vector<LightFrame>& later) {
  if (!later.empty()) {
    light.key_count = static_cast<uint32_t>(1 + later.size());
    light.first_key = static_cast<uint32_t>(frames_.size());
    frames_.push_back(first);
    frames_.insert(frames_.end(), later.begin(), later.end());
  }
  punctuals_.push_back(light);
  punctual_names_.push_back(name);
}

void LightSet::add_punctuals(const LightSetInput& input) {
  const auto inverse = [](const std::optional<float>& range_m) {
    return range_m && *range_m > 0.0f ? 1.0f / *range_m : 0.0f;
  };
  for (const PointLight& light : input.points) {
    Punctual p{Punctual::Kind::point, light.position, V3f(0.0f), light.intensity};
    p.inverse_range = inverse(light.range_m);
    p.radius = accepted_size(light.radius_m);
    add_punctual(p, light.name, {light.position}, light.later);
  }
  for (const SpotLight& light : input.spots) {
    Punctual p{Punctual::Kind::spot, light.position, light.axis, light.intensity};
    p.inverse_range = inverse(light.range_m);
    p.angle_scale = 1.0f / std::max(0.001f, light.cos_inner - light.cos_outer);
    p.angle_offset = -light.cos_outer * p.angle_scale;
    p.radius = accepted_size(light.radius_m);
    LightFrame frame{light.position};
    frame.z = -light.axis;
    add_punctual(p, light.name, frame, light.later);
  }
  for (const ProfiledLight& light : profiled_) {
    Punctual p{Punctual::Kind::profiled, light.position, -light.axes[2], light.intensity};
    p.profiled = static_cast<uint32_t>(&light - profiled_.data());
    p.radius = accepted_size(light.radius_m);
    p.x = light.axes[0];
    p.y = light.axes[1];
    add_punctual(p, light.name, {light.position, light.axes[0], light.axes[1], light.axes[2]}, light.later);
  }
  first_directional_ = punctuals_.size();
  for (const DirectionalLight& light : input.directionals) {
    Punctual p{Punctual::Kind::directional, V3f(0.0f), light.direction, light.irradiance};
    const float half = 0.5f * accepted_size(std::min(light.angular_diameter_rad, kPi));
    p.radius = half > 0.0f ? elementary::sin(half) : 0.0f;
    p.one_minus_cos = 2.0f * square(elementary::sin(0.5f * half));
    LightFrame frame;
    frame.z = -light.direction;
    add_punctual(p, light.name, frame, light.later);
  }
  for (Punctual& p : punctuals_) {
    const float factor = p.kind == Punctual::Kind::profiled ? profiled_[p.profiled].profile->typical_intensity() : 1.0f;
    p.luminance = accepted(static_cast<double>(luminance(p.intensity)) * static_cast<double>(factor));
  }
  prepare_shapes();
}

// Prepares the shapes that rays can hit, and the reach of directional lights.
void LightSet::prepare_shapes() {
  std::vector<SphereTree::Sphere> spheres;
  for (uint32_t i = 0; i < punctuals_.size(); ++i) {
    Punctual& p = punctuals_[i];
    const bool in_sky = i >= first_directional_;
    const auto frames = std::span(frames_).subspan(p.first_key, p.key_count);
    if (in_sky && (p.radius > 0.0f || !frames.empty())) {
      const Cone swept = cone_of_axes(-p.axis, frames);
      p.sin_reach = elementary::sin(std::min(swept.angle + elementary::asin(std::min(p.radius, 1.0f)), 0.5f * kPi));
      p.axis = -swept.axis;
    }
    if (!(p.radius > 0.0f && p.luminance > 0.0f)) continue;
    if (in_sky) {
      disks_.push_back(i);
      continue;
    }
    const EmitterBounds bounds = punctual_bounds(p);
    if (bounds.intensity > 0.0f) spheres.push_back({bounds.center, bounds.radius, i});
  }
  spheres_ = SphereTree(std::move(spheres));
  has_shapes_ = !spheres_.empty() || !disks_.empty();
}

EmitterBounds LightSet::punctual_bounds(const Punctual& light) const {
  const auto frames = std::span(frames_).subspan(light.first_key, light.key_count);
  EmitterBounds result;
  result.center = light.position;
  bool finite = is_finite(light.position);
  if (!frames.empty()) {
    Box3f path;
    for (const LightFrame& frame : frames) {
      path.extendBy(frame.position);
      finite = finite && is_finite(frame.position) && is_finite(frame.z);
    }
    result.center = (path.min + path.max) * 0.5f;
    result.radius = 0.5f * (path.max - path.min).length() * (1.0f + 1e-6f);
  }
  result.radius += light.radius * (1.0f + 1e-6f);
  result.radius +=
      4e-7f * max_component({std::fabs(light.position.x), std::fabs(light.position.y), std::fabs(light.position.z)});
  result.intensity = finite ? light.luminance : 0.0f;
  result.cos_normals = -1.0f;
  if (light.kind == Punctual::Kind::spot) {
    // Full intensity inside of the cone and none outside: the normals fill the cone and emit
    // straight on.
    result.axis = light.axis;
    result.cos_normals = std::clamp(-light.angle_offset / light.angle_scale - 1e-5f, -1.0f, 1.0f);
    result.cos_emission = 1.0f - 1e-4f;
    if (!frames.empty()) {
      const Cone swept = cone_of_axes(-light.axis, frames);
      result.axis = -swept.axis;
      const float angle = elementary::acos(result.cos_normals) + swept.angle;
      result.cos_normals = angle < kPi ? elementary::cos(angle) : -1.0f;
    }
  }
  return result;
}

Rgb LightSet::mean_emission(uint32_t index) const {
  const Emission& emission = emissions_[triangles_[index].emission];
  if (emission.texture == nullptr || uvs_.empty()) return emission.factor;
  // Samples a grid as fine as the texels that the triangle covers, between 2 and 32 steps along an
  // edge. Missed emission is not lost: rays still hit light that is never sampled.
  const V2f* uv = uvs_.data() + size_t{index} * 3;
  const V2f size(emission.texture->size_px());
  const float longest = std::max(((uv[1] - uv[0]) * size).length(),
                                 std::max(((uv[2] - uv[1]) * size).length(), ((uv[0] - uv[2]) * size).length()));
  const int steps = longest < 32.0f ? std::max(static_cast<int>(longest), 2) : 32; // NaN: 32
  V3d sum(0.0);
  int count = 0;
  for (int i = 0; i < steps; ++i) {
    for (int j = 0; j < steps - i; ++j) {
      // Centroids of the small triangles, upright and (except for the last of a row) inverted.
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
         uvs_.size() * sizeof(V2f) + meshes_.size() * sizeof(EmissiveMesh) + moving_.size() * sizeof(CornerKeys) +
         later_corners_.size() * sizeof(later_corners_[0]) +
         punctuals_.size() * (sizeof(Punctual) + sizeof(std::string)) + frames_.size() * sizeof(LightFrame) +
         spheres_.memory_bytes() + tree_.memory_bytes() + (environment_ ? environment_->memory_bytes() : 0);
}

} // namespace kindling
