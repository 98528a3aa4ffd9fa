// Provides the geometric streams of a hit to procedural textures.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/procedural_lookup.h"

#include "renderer/base/hash.h"
#include "renderer/world/texture_lookup.h"

#include <algorithm>
#include <cmath>

namespace kindling {
namespace {

using Stream = ProceduralStream;

constexpr int kMaxPoints = 4; // of a footprint: 16 give the same noise for more time (renderer/texture/README.md)
constexpr float kMaxStretch = 16.0f; // a footprint's longer axis over its shorter one

V4f extended(const V3f& v, float w = 1.0f) { return {v.x, v.y, v.z, w}; }

// Interpolates values at the corners of a triangle.
class Interpolator {
 public:
  Interpolator(const HitRecords& records, const V2f (&across)[2])
      : barycentric_(records.barycentric), across_{across[0], across[1]} {}

  // `corner(k)` returns a V4f.
  template <typename F>
  [[nodiscard]] ProceduralSample operator()(const F& corner) const {
    const V4f a = corner(0), b = corner(1), c = corner(2);
    ProceduralSample sample;
    sample.value = a * barycentric_.x + b * barycentric_.y + c * barycentric_.z;
    for (int axis = 0; axis < 2; ++axis) sample.across[axis] = (b - a) * across_[axis].x + (c - a) * across_[axis].y;
    return sample;
  }

 private:
  V3f barycentric_;
  V2f across_[2];
};

// Computes the change of the barycentric coordinates of the second and third corner across the
// footprint: along the ray's projection to the surface, and perpendicular to it.
void footprint_axes(const V3f (&corners)[3], const SurfaceFootprint& seen, V2f (&across)[2]) {
  const V3f e1 = corners[1] - corners[0], e2 = corners[2] - corners[0];
  const V3f n = e1.cross(e2);
  const float n2 = n.length2();
  if (!(n2 > 0.0f) || !std::isfinite(n2)) return;
  const V3f& d = seen.ray.direction;
  const float along = d.dot(n);
  V3f major = d - n * (along / n2);
  if (!(major.length2() > 1e-12f)) major = e1;
  major.normalize();
  const V3f minor = n.cross(major).normalized();
  const float cosine = std::abs(along) / std::sqrt(n2);
  const float width = seen.footprint.width_m;
  const V3f axes[2] = {major * (width / std::max(cosine, 1.0f / kMaxStretch)), minor * width};
  for (int axis = 0; axis < 2; ++axis)
    across[axis] = V2f(axes[axis].cross(e2).dot(n) / n2, e1.cross(axes[axis]).dot(n) / n2);
}

} // namespace

V4f ProceduralScene::sample(int number, const HitRecords& records, const SurfaceFootprint& footprint,
                            bool filtered) const {
  const ProceduralTextureView& texture = textures[static_cast<size_t>(number)];
  const GeometryView& geometry = records.geometry;
  const WorldInstance& instance = instances[records.hit->instance];
  const uint32_t* index = geometry.indices.data() + size_t{records.hit->triangle} * 3;
  V3f stored[3], world[3];
  for (int k = 0; k < 3; ++k) {
    stored[k] = geometry.positions[index[k]];
    world[k] = instance.identity ? stored[k] : transform_point(instance.object_to_world, stored[k]);
  }
  const M44f& object = geometry.to_object;

  V2f across[2] = {V2f(0.0f), V2f(0.0f)};
  if (filtered && footprint.footprint.width_m > 0.0f) footprint_axes(world, footprint, across);
  const Interpolator interpolate(records, across);

  const auto normals = [&](const M44f& to_space, bool moved) {
    ProceduralSample sample = interpolate([&](int k) {
      if (geometry.normal_offset == GeometryView::kAbsent) {
        const V3f face = (stored[1] - stored[0]).cross(stored[2] - stored[0]);
        return extended(moved ? transform_normal_direction(to_space, face) : face);
      }
      const float* at = records.records[static_cast<size_t>(k)] + geometry.normal_offset;
      const V3f n(at[0], at[1], at[2]);
      return extended(moved ? transform_normal_direction(to_space, n) : n);
    });
    const float length = V3f(sample.value.x, sample.value.y, sample.value.z).length();
    const float scale = length > 0.0f ? 1.0f / length : 0.0f;
    sample.value *= scale;
    for (V4f& change : sample.across) change *= scale;
    return sample;
  };

  std::array<ProceduralSample, kProceduralStreams> samples;
  size_t count = 0;
  for (const Stream stream : texture.streams) {
    ProceduralSample& sample = samples[count++];
    switch (stream) {
    case Stream::position_object:
      sample = interpolate([&](int k) { return extended(transform_point(object, stored[k])); });
      break;
    case Stream::position_world: sample = interpolate([&](int k) { return extended(world[k]); }); break;
    case Stream::normal_object: sample = normals(object, object != M44f()); break;
    case Stream::normal_world: sample = normals(instance.object_to_world, !instance.identity); break;
    case Stream::color:
      sample = interpolate([&](int k) {
        if (geometry.color_offset == GeometryView::kAbsent) return V4f(1.0f);
        const float* at = records.records[static_cast<size_t>(k)] + geometry.color_offset;
        return V4f(at[0], at[1], at[2], at[3]);
      });
      break;
    default: {
      const uint8_t offset = geometry.texcoord_offset[static_cast<size_t>(stream)];
      sample = interpolate([&](int k) {
        if (offset == GeometryView::kAbsent) return V4f(0.0f, 0.0f, 0.0f, 1.0f);
        const float* at = records.records[static_cast<size_t>(k)] + offset;
        return V4f(at[0], at[1], 0.0f, 1.0f);
      });
    }
    }
  }
  // Over the samples of a key the points fill the footprint evenly (Roberts 2018: R2).
  const uint32_t key = footprint.ray.key, number_of_sample = footprint.ray.index;
  const V2f shift(to_unit_float(hash_u32(key) + number_of_sample * 0xc13fa9a9U),
                  to_unit_float(hash_u32(key ^ 0x68bc21ebU) + number_of_sample * 0x91e10da5U));
  return texture.evaluate({samples.data(), count}, images, shift, kMaxPoints);
}

} // namespace kindling
