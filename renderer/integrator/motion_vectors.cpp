// Projects points of surfaces at the times of three frames.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/motion_vectors.h"

#include "renderer/world/hit_records.h"

#include <optional>
#include <span>

namespace kindling {
namespace {

// Writes the way from one film position to another; y upwards.
void set_way(const std::optional<V2f>& from, const std::optional<V2f>& to, float (&way)[2]) {
  if (!from || !to) return;
  way[0] = to->x - from->x;
  way[1] = from->y - to->y;
}

} // namespace

MotionVectors::MotionVectors(const World& world, const Camera& camera, const FrameMotion& motion)
    : world_(world), camera_(camera), motion_(motion), primitives_(world.geometries.size(), 0) {
  std::vector<uint8_t> begins(world.geometries.size() + 1, 0); // a group, or in that of baked geometry a node
  for (const WorldInstance& instance : world.instances) begins[instance.first_mesh] = 1;
  for (uint32_t mesh = 1; mesh < primitives_.size(); ++mesh)
    if (begins[mesh] == 0 && world.node_of(mesh, 0) == world.node_of(mesh - 1, 0))
      primitives_[mesh] = primitives_[mesh - 1] + 1;
}

void MotionVectors::measure(const accel::Hit& hit, const V3f& position, NearestSample& sample) const {
  const GeometryView& geometry = world_.geometries[hit.mesh];
  const SurfaceMotion::Place place{
      .node = world_.node_of(hit),
      .primitive = primitives_[hit.mesh],
      .vertices = std::span<const uint32_t, 3>(geometry.indices.data() + size_t{hit.triangle} * 3, 3),
      .barycentric = HitRecords(geometry, hit).barycentric,
      .local_to_world = geometry.to_object.inverse() * world_.instances[hit.instance].object_to_world};
  const std::optional<V2f> now = camera_.project(position);
  set_way(now, motion_.previous.camera.project(motion_.previous.surfaces.move(place, position)), sample.to_previous);
  set_way(now, motion_.next.camera.project(motion_.next.surfaces.move(place, position)), sample.to_next);
}

void MotionVectors::measure_background(const V3f& direction, NearestSample& sample) const {
  if (camera_.is_orthographic()) return;
  const auto seen_by = [&](const Camera& camera) { return camera.project(camera.position() + direction); };
  const std::optional<V2f> now = seen_by(camera_);
  set_way(now, seen_by(motion_.previous.camera), sample.to_previous);
  set_way(now, seen_by(motion_.next.camera), sample.to_next);
}

} // namespace kindling
