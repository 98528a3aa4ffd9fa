// Ids and geometry of first hits.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/first_hits.h"

#include "renderer/film/cryptomatte.h"
#include "renderer/integrator/stages/camera_ray.h"

#include <algorithm>
#include <cassert>

namespace kindling {

FirstHits::FirstHits(const World& world, const Camera& camera, const PixelFilter& filter, AovSet aovs,
                     const AovInputs& inputs)
    : world_(world), camera_(camera), filter_(filter), wanted_(aovs.needs_first_hit()), nearest_(aovs.needs_nearest()) {
  if (aovs.needs_motion() && inputs.motion) motion_.emplace(world, camera, *inputs.motion);
  if (!aovs.has_mattes()) return;
  const SurfaceNames* const names = inputs.names;
  assert(names != nullptr);
  std::vector<uint32_t> node_ids;
  for (const std::string& name : names->nodes) node_ids.push_back(matte_id(name));
  for (size_t i = 0; i < node_ids.size(); ++i)
    nodes_.push_back({aovs.contains(Matte::object) ? node_ids[i] : 0,
                      aovs.contains(Matte::asset) ? node_ids[static_cast<size_t>(names->roots[i])] : 0});
  for (const std::string& name : names->materials)
    materials_.push_back(aovs.contains(Matte::material) ? matte_id(name) : 0);
}

MatteIds FirstHits::ids_at(const accel::Hit& hit) const {
  const NodeIds& node = nodes_[static_cast<size_t>(world_.node_of(hit))];
  return {node.object, materials_[world_.geometries[hit.mesh].material], node.asset};
}

NearestSample FirstHits::describe(const CameraSample& sample, const accel::Hit& hit) const {
  NearestSample nearest{.number = sample.sample_index + 1};
  if (!hit.is_hit() && !motion_) return nearest;
  float weight = 0.0f;
  const accel::Ray ray =
      make_camera_ray(camera_, filter_, draw_camera(camera_, sample.address), sample.pixel, sample.address, weight);
  if (!hit.is_hit()) {
    motion_->measure_background(ray.direction, nearest);
    return nearest;
  }
  SurfacePoint surface;
  world_.surface_at(ray, hit, surface);
  nearest.object_id = static_cast<uint32_t>(world_.node_of(hit)) + 1;
  nearest.material_id = world_.geometries[hit.mesh].material + 1;
  nearest.depth = camera_.depth(surface.position, ray.time);
  for (int c = 0; c < 3; ++c) nearest.position[c] = surface.position[c];
  const V2f uv = world_.texcoord_at(hit);
  nearest.uv[0] = uv.x;
  nearest.uv[1] = uv.y;
  if (motion_) motion_->measure(hit, surface.position, nearest);
  return nearest;
}

void FirstHits::add(const CameraSample& sample, const accel::Hit& hit, Film& film) const {
  if (!nodes_.empty() && hit.is_hit()) film.add_matte(sample.pixel, ids_at(hit), sample.filter_weight);
  if (!nearest_) return;
  const V2f offset = filter_.sample(Sampler::sample_2d(sample.address, kFilterDimension)).offset;
  const float distance2 = offset.x * offset.x + offset.y * offset.y;
  if (!film.wants_nearest(sample.pixel, sample.sample_index + 1, distance2)) return;
  NearestSample nearest = describe(sample, hit);
  nearest.distance2 = distance2;
  film.add_nearest(sample.pixel, nearest);
}

} // namespace kindling
