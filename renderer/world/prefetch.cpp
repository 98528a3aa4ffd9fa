// Prefetches the memory of many hits for shading, in steps that depend on each other's addresses.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/prefetch.h"
#include "renderer/world/moving_hit.h"
#include "renderer/world/texture_lookup.h"
#include "renderer/world/world_view.h"

#include <optional>

namespace kindling {
namespace {

// Prefetches the textures that most materials have.
void prefetch_textures(const ShadingMaterial& material, const TextureLookup& lookup,
                       std::span<const TextureView> textures) {
  for (const TextureBinding* binding :
       {&material.base_color, &material.metallic_roughness, &material.normal, &material.emission}) {
    if (!binding->present() || binding->is_procedural()) continue;
    const TextureLookup::Place at = lookup.place(*binding);
    textures[static_cast<size_t>(binding->texture)].prefetch(at.uv, at.level);
  }
}

[[gnu::noinline, gnu::cold]] V3f moving_face_normal(const GeometryView& geometry, const WorldInstance& instance,
                                                    std::span<const std::span<const M44f>> motions,
                                                    const accel::Hit& hit, float time) {
  std::optional<MovingHit> moving;
  const auto& [p0, p1, p2] = move_hit(geometry, instance, motions, hit.triangle, time, moving).positions;
  const M44f& m = moving->instance.object_to_world;
  const V3f origin = transform_point(m, p0); // the operations of WorldView::surface_at()
  return (transform_point(m, p1) - origin).cross(transform_point(m, p2) - origin);
}

V3f face_normal(const GeometryView& geometry, const WorldInstance& instance, const accel::Hit& hit) {
  const uint32_t* index = geometry.indices.data() + size_t{hit.triangle} * 3;
  V3f p0 = geometry.positions[index[0]], p1 = geometry.positions[index[1]], p2 = geometry.positions[index[2]];
  if (!instance.identity) {
    p0 = transform_point(instance.object_to_world, p0);
    p1 = transform_point(instance.object_to_world, p1);
    p2 = transform_point(instance.object_to_world, p2);
  }
  return (p1 - p0).cross(p2 - p0);
}

} // namespace

void WorldView::prefetch(std::span<const accel::Ray> rays, std::span<const accel::Hit> hits,
                         std::span<RayFootprint> footprints) const {
  if (!exceeds_caches) return;
  for (const accel::Hit& hit : hits) {
    if (!hit.is_hit()) continue;
    ::kindling::prefetch(geometries[hit.mesh].indices.data() + size_t{hit.triangle} * 3);
    if (!contacts.empty()) contacts.prefetch(hit);
  }
  for (const accel::Hit& hit : hits) {
    if (!hit.is_hit()) continue;
    const GeometryView& geometry = geometries[hit.mesh];
    const uint32_t* index = geometry.indices.data() + size_t{hit.triangle} * 3;
    for (size_t corner = 0; corner < 3; ++corner) {
      ::kindling::prefetch(&geometry.positions[index[corner]]);
      const float* record = geometry.record(index[corner]);
      ::kindling::prefetch(record);
      if (geometry.stride > 0) ::kindling::prefetch(record + geometry.stride - 1);
    }
  }
  if (textures.empty()) return;
  for (size_t i = 0; i < hits.size(); ++i) {
    const accel::Hit& hit = hits[i];
    if (!hit.is_hit()) continue;
    const GeometryView& geometry = geometries[hit.mesh];
    const ShadingMaterial& material = materials[geometry.material];
    if (!material.textured) continue;
    const WorldInstance& instance = instances[hit.instance];
    const V3f normal = instance.moving ? moving_face_normal(geometry, instance, motions, hit, rays[i].time)
                                       : face_normal(geometry, instance, hit);
    const SurfaceFootprint seen{rays[i], footprints[i], normal};
    footprints[i].choice = seen.choice();
    footprints[i].relative_area = seen.relative_area();
    const HitRecords records(geometry, hit);
    prefetch_textures(material, TextureLookup(textures, procedurals, records, seen), textures);
  }
}

} // namespace kindling
