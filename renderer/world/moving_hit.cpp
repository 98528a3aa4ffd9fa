// Interpolates a moving triangle between the keys of its motion.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/moving_hit.h"

#include "accel/motion.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace kindling {
namespace {

// Returns a bound of the coordinates of a transformed point with coordinates up to `magnitude`.
float magnitude_through(const M44f& m, float magnitude) {
  const auto row = [&m](int i) { return max_abs(V3f(m[i][0], m[i][1], m[i][2])); };
  return (row(0) + row(1) + row(2)) * magnitude + row(3);
}

void lerp_record(const GeometryView& geometry, uint32_t vertex, const accel::KeyInterval& at, float* record) {
  const float* own = geometry.record(vertex);
  std::copy(own, own + geometry.stride, record);
  const float* after = geometry.later_frames[at.first].data() + size_t{vertex} * geometry.frame_floats();
  const float* before =
      at.first == 0 ? nullptr : geometry.later_frames[at.first - 1].data() + size_t{vertex} * geometry.frame_floats();
  const auto blend = [&](uint8_t offset, int floats) {
    if (offset == GeometryView::kAbsent) return;
    for (int c = 0; c < floats; ++c)
      record[offset + c] = lerp(before ? *before++ : own[offset + c], *after++, at.fraction);
  };
  blend(geometry.normal_offset, 3);
  blend(geometry.tangent_offset, 3);
}

} // namespace

const MovingHit& move_hit(const GeometryView& geometry, const WorldInstance& instance,
                          std::span<const std::span<const M44f>> motions, uint32_t triangle, float time,
                          std::optional<MovingHit>& moving) {
  constexpr float kEpsilon = std::numeric_limits<float>::epsilon() * 16.0f;
  assert(instance.moving && size_t{triangle} * 3 < geometry.indices.size());
  MovingHit& out = moving.emplace();
  out.instance = instance;
  const uint32_t* index = geometry.indices.data() + size_t{triangle} * 3;
  float magnitude = 0.0f;
  if (geometry.later_positions.empty()) {
    for (size_t corner = 0; corner < 3; ++corner) {
      out.positions[corner] = geometry.positions[index[corner]];
      out.records[corner] = geometry.record(index[corner]);
      magnitude = std::max(magnitude, max_abs(out.positions[corner]));
    }
  } else {
    const accel::KeyInterval at =
        accel::key_interval(accel::clamped_time(time), static_cast<uint32_t>(geometry.later_positions.size()));
    const std::span<const V3f> before = at.first == 0 ? geometry.positions : geometry.later_positions[at.first - 1];
    const std::span<const V3f> after = geometry.later_positions[at.first];
    for (size_t corner = 0; corner < 3; ++corner) {
      const V3f &a = before[index[corner]], &b = after[index[corner]];
      out.positions[corner] = lerp(a, b, at.fraction);
      magnitude = std::max(magnitude, std::max(max_abs(a), max_abs(b)));
      lerp_record(geometry, index[corner], at, out.copies[corner].data());
      out.records[corner] = out.copies[corner].data();
    }
    out.error = kEpsilon * magnitude;
  }
  if (instance.motion != accel::kNoId) {
    const std::span<const M44f> keys = motions[instance.motion];
    const accel::KeyInterval at =
        accel::key_interval(accel::clamped_time(time), static_cast<uint32_t>(keys.size() - 1));
    out.instance.object_to_world = accel::between(keys[at.first], keys[at.first + 1], at.fraction);
    out.instance.mirrored = out.instance.object_to_world.determinant() < 0.0f;
    out.error = kEpsilon * std::max(magnitude_through(keys[at.first], magnitude),
                                    magnitude_through(keys[at.first + 1], magnitude));
  }
  return out;
}

} // namespace kindling
