// Emissive triangles that move over the shutter: their corners at a time.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_set_view.h"

namespace kindling {

LightSetView::Triangle LightSetView::triangle_at_key(uint32_t index, uint32_t key) const {
  Triangle result = triangles[index];
  if (key == 0) return result;
  const std::array<V3f, 3>& corners = later_corners[moving[index - first_moving].first + key - 1];
  result.p0 = corners[0];
  result.p1 = corners[1];
  result.p2 = corners[2];
  return result;
}

LightSetView::Triangle LightSetView::posed_triangle(uint32_t index, float time) const {
  const CornerKeys& keys = moving[index - first_moving];
  if (keys.count == 0) return triangles[index];
  const accel::KeyInterval at = accel::key_interval(accel::clamped_time(time), keys.count);
  Triangle result = triangle_at_key(index, at.first);
  const Triangle next = triangle_at_key(index, at.first + 1);
  result.p0 = between(result.p0, next.p0, at.fraction);
  result.p1 = between(result.p1, next.p1, at.fraction);
  result.p2 = between(result.p2, next.p2, at.fraction);
  return result;
}

} // namespace kindling
