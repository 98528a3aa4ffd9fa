// The second test of Embree's candidates, with the arithmetic of the other accelerators.
// SPDX-License-Identifier: Apache-2.0
#include "accel/embree/embree_all_hits.h"

#include "accel/motion.h"

#include <algorithm>
#include <cassert>
#include <limits>

namespace kindling::accel::embree {

CrossingScene::CrossingScene(const BuildInput& input)
    : meshes_(input.meshes.begin(), input.meshes.end()), placed_(input.instances.size()), filter_(input.filter) {
  for (size_t i = 0; i < placed_.size(); ++i) {
    const Instance& instance = input.instances[i];
    if (instance.motion != kNoId) {
      const std::span<const Imath::M44f> keys = input.motions[instance.motion];
      placed_[i].keys.assign(keys.begin(), keys.end());
    } else {
      placed_[i].identity = is_identity(instance.object_to_world);
      (void)placed_[i].to_object.set_inverse_of(instance.object_to_world); // others are not in Embree's scenes
    }
  }
}

bool CrossingScene::to_object(const Ray& world, uint32_t instance, Ray& inside) const {
  assert(instance < placed_.size());
  const Placed& placed = placed_[instance];
  if (placed.identity) {
    inside = world;
    return true;
  }
  RayToObject inverse = placed.to_object;
  if (!placed.keys.empty() && !inverse.set_inverse_of(matrix_at(placed.keys, world.time))) return false;
  inside = inverse(world);
  return can_hit(inside);
}

bool CrossingScene::cross(const Ray& inside, const RayShear& shear, float t_far, Crossing& crossing) const {
  Hit& hit = crossing.hit;
  const TriangleMesh& mesh = meshes_[hit.mesh];
  const uint32_t* corner = &mesh.indices[3 * static_cast<size_t>(hit.triangle)];
  for (uint32_t key = 0; key < key_count(mesh); ++key) {
    const std::span<const Imath::V3f> p = positions_at_key(mesh, key);
    if (deforms(mesh) ? !is_finite(p[corner[0]]) || !is_finite(p[corner[1]]) || !is_finite(p[corner[2]])
                      : !can_be_hit(p[corner[0]], p[corner[1]], p[corner[2]]))
      return false;
  }
  const PositionsAt positions(mesh, inside.time);
  const auto sheared = [&](const Imath::V3f& p) { return ShearedCorner(shear, p[shear.kx], p[shear.ky], p[shear.kz]); };
  const ShearedCorner a = sheared(positions[corner[0]]), b = sheared(positions[corner[1]]),
                      c = sheared(positions[corner[2]]);
  return intersect_sheared(a, b, c, shear.sz, std::max(inside.t_min, 0.0f), t_far, hit.t, hit.u, hit.v) &&
         crosses_sheared(a, b, c, shear.sz, crossing.front);
}

bool CrossingScene::accepts(const Ray& world, const Hit& hit) const {
  return meshes_[hit.mesh].opaque || filter_.accept == nullptr || filter_.accept(filter_.context, world, hit);
}

size_t CrossingScene::memory_bytes() const {
  size_t bytes = meshes_.capacity() * sizeof(TriangleMesh) + placed_.capacity() * sizeof(Placed);
  for (const Placed& placed : placed_) bytes += placed.keys.capacity() * sizeof(Imath::M44f);
  return bytes;
}

void Crossings::test(const Hit& candidate) {
  if (candidate.instance != instance_) {
    instance_ = candidate.instance;
    meets_instance_ = scene_.to_object(world_, instance_, inside_);
    if (meets_instance_) shear_ = RayShear(inside_.origin, inside_.direction);
  }
  Crossing crossing{candidate, false};
  const float t_far = std::min(collector_.t_far(), std::numeric_limits<float>::max());
  if (meets_instance_ && scene_.cross(inside_, shear_, t_far, crossing) && scene_.accepts(world_, crossing.hit))
    collector_.add(crossing);
}

} // namespace kindling::accel::embree
