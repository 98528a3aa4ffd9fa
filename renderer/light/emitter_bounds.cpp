// Bounds of moving triangles and of punctual lights for the light tree; mean emission.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/elementary.h"
#include "renderer/light/cone_of_axes.h"
#include "renderer/light/light_set.h"

#include <cmath>

namespace kindling {

// Corners move linearly, so a sphere around those of all keys contains them at all times. Between
// keys a and b the normal is (1 - t)^2 na + 2 t (1 - t) m + t^2 nb with m = (ea x fb + eb x fa) / 2
// of the edges e and f: a cone around the three vectors contains it.
EmitterBounds LightSet::moving_bounds(uint32_t index) const {
  EmitterBounds result;
  const uint32_t last = moving[index - first_moving].count;
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

EmitterBounds LightSet::punctual_bounds(const Punctual& light) const {
  const auto keys = frames.subspan(light.first_key, light.key_count);
  EmitterBounds result;
  result.center = light.position;
  bool finite = is_finite(light.position);
  if (!keys.empty()) {
    Box3f path;
    for (const LightFrame& frame : keys) {
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
    if (!keys.empty()) {
      const Cone swept = cone_of_axes(-light.axis, keys);
      result.axis = -swept.axis;
      const float angle = elementary::acos(result.cos_normals) + swept.angle;
      result.cos_normals = angle < kPi ? elementary::cos(angle) : -1.0f;
    }
  }
  return result;
}

Rgb LightSet::mean_emission(uint32_t index) const {
  const Emission& emission = emissions[triangles[index].emission];
  if (emission.texture == nullptr || uvs.empty()) return emission.factor;
  // Samples a grid as fine as the texels that the triangle covers, between 2 and 32 steps along an
  // edge. Missed emission is not lost: rays still hit light that is never sampled.
  const V2f* uv = uvs.data() + size_t{index} * 3;
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

} // namespace kindling
