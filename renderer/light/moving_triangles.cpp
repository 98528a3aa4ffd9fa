// Emissive triangles that move over the shutter: their corners at a time, and bounds for all times.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_set.h"

namespace kindling {

LightSet::Triangle LightSet::triangle_at_key(uint32_t index, uint32_t key) const {
  Triangle result = triangles_[index];
  if (key == 0) return result;
  const std::array<V3f, 3>& corners = later_corners_[moving_[index - first_moving_].first + key - 1];
  result.p0 = corners[0];
  result.p1 = corners[1];
  result.p2 = corners[2];
  return result;
}

LightSet::Triangle LightSet::posed_triangle(uint32_t index, float time) const {
  const CornerKeys& keys = moving_[index - first_moving_];
  if (keys.count == 0) return triangles_[index];
  const accel::KeyInterval at = accel::key_interval(accel::clamped_time(time), keys.count);
  Triangle result = triangle_at_key(index, at.first);
  const Triangle next = triangle_at_key(index, at.first + 1);
  result.p0 = between(result.p0, next.p0, at.fraction);
  result.p1 = between(result.p1, next.p1, at.fraction);
  result.p2 = between(result.p2, next.p2, at.fraction);
  return result;
}

// Corners move linearly, so a sphere around those of all keys contains them at all times. Between
// keys a and b the normal is (1 - t)^2 na + 2 t (1 - t) m + t^2 nb with m = (ea x fb + eb x fa) / 2
// of the edges e and f: a cone around the three vectors contains it.
EmitterBounds LightSet::moving_bounds(uint32_t index) const {
  EmitterBounds result;
  const uint32_t last = moving_[index - first_moving_].count;
  Box3f box;
  V3d axis(0.0);
  double double_areas = 0.0;
  for (uint32_t key = 0; key <= last; ++key) {
    const Triangle t = triangle_at_key(index, key);
    const V3f normal = (t.p1 - t.p0).cross(t.p2 - t.p0);
    const auto double_area = static_cast<double>(normal.length());
    if (!std::isfinite(double_area) || !is_finite(t.p0)) return {}; // never selected
    for (const V3f& p : {t.p0, t.p1, t.p2}) box.extendBy(p);
    axis += V3d(normal);
    double_areas += double_area;
  }
  if (!(double_areas > 0.0)) return {};
  result.center = (box.min + box.max) * 0.5f;
  const float largest = std::max(max_component({std::fabs(box.min.x), std::fabs(box.min.y), std::fabs(box.min.z)}),
                                 max_component({std::fabs(box.max.x), std::fabs(box.max.y), std::fabs(box.max.z)}));
  result.radius = 0.5f * (box.max - box.min).length() * (1.0f + 1e-6f) + largest * 4e-7f;
  const double mean = double_areas / (last + 1.0);
  result.intensity = static_cast<float>(0.5 * mean * static_cast<double>(luminance(mean_emission(index))));
  result.cos_normals = -1.0f;
  if (!(axis.length() > 0.1 * double_areas)) return result;
  axis.normalize();
  result.axis = V3f(axis);
  double spread = 0.0; // sine of the angle that contains all
  const auto hold = [&](const V3f& normal) {
    const V3d n(normal);
    const double length = n.length();
    if (n.dot(axis) > 0.0 && length > 1e-6 * mean)
      spread = std::max(spread, n.cross(axis).length() / length);
    else if (length > 0.0)
      spread = 2.0;
  };
  for (uint32_t key = 0; key <= last; ++key) {
    const Triangle a = triangle_at_key(index, key);
    hold((a.p1 - a.p0).cross(a.p2 - a.p0));
    if (key == last) continue;
    const Triangle b = triangle_at_key(index, key + 1);
    hold(((a.p1 - a.p0).cross(b.p2 - b.p0) + (b.p1 - b.p0).cross(a.p2 - a.p0)) * 0.5f);
  }
  if (spread < 0.99)
    result.cos_normals = static_cast<float>(std::sqrt(1.0 - square(static_cast<float>(spread)))) - 1e-6f;
  return result;
}

} // namespace kindling
