// Recording of a finished path: the light that each of its reflections brought.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/path_recorder.h"

namespace kindling {

void PathRecorder::drop(size_t slot) {
  Path& path = paths_[slot];
  if (!path.in_flight) return;
  path.in_flight = false;
  --path.count;
}

void PathRecorder::arrive_at(size_t slot, const PathState& state, const V3f& hit, uint32_t hit_facing, uint8_t hit_kind,
                             bool sampled) {
  Path& path = paths_[slot];
  if (!path.in_flight) return;
  Reflection& reflection = reflections_[slot * kMaxReflections + path.count - 1];
  GuideRecord& record = reflection.record;
  if (hit == record.position) return drop(slot);
  path.in_flight = false;
  record.hit = hit;
  record.hit_facing = hit_facing;
  record.hit_kind = hit_kind;
  if (sampled) record.environment = std::min(record.environment, record.replaced);
  reflection.found_before = luminance(state.light[0] + state.light[1] + state.light[2]);
}

void PathRecorder::escape(size_t slot, const PathState& state, const V3f& direction, const Box3f& bounds) {
  const Path& path = paths_[slot];
  if (!path.in_flight) return;
  const V3f from = reflections_[slot * kMaxReflections + path.count - 1].record.position;
  float nearest = kInfinity;
  uint32_t facing = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0f) continue;
    const bool up = direction[axis] > 0.0f;
    const float distance = ((up ? bounds.max : bounds.min)[axis] - from[axis]) / direction[axis];
    if (distance >= nearest) continue;
    nearest = distance;
    facing = 2 * static_cast<uint32_t>(axis) + (up ? 1 : 0);
  }
  if (nearest > 0.0f && nearest < kInfinity)
    arrive_at(slot, state, from + direction * nearest, facing, kOnBounds, true);
  else
    drop(slot);
}

void PathRecorder::finish_path(size_t slot, const Rgb& found) {
  const float total = luminance(found);
  if (!std::isfinite(total)) return;
  luminance_sum += static_cast<double>(total);
  const Path& path = paths_[slot];
  const size_t arrived = path.count - (path.in_flight ? 1 : 0);
  for (size_t i = 0; i < arrived; ++i) {
    const Reflection& reflection = reflections_[slot * kMaxReflections + i];
    const float brought = total - reflection.found_before;
    if (!(brought > 0.0f)) continue;
    GuideRecord& record = records.emplace_back(reflection.record);
    record.contribution2 = square(brought);
  }
}

} // namespace kindling
