// Asks for what shading will read of many hits before it is needed, each step once the step before has brought its addresses.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/prefetch.h"
#include "renderer/world/hit_records.h"
#include "renderer/world/world.h"

namespace kindling {
namespace {

// Of the textures that most materials have.
void prefetch_textures(const ShadingMaterial& material, const HitRecords& lookup, std::span<const Texture> textures) {
  for (const TextureBinding* binding :
       {&material.base_color, &material.metallic_roughness, &material.normal, &material.emission}) {
    if (binding->present()) textures[static_cast<size_t>(binding->texture)].prefetch(lookup.texcoord(*binding));
  }
}

} // namespace

void World::prefetch(std::span<const accel::Hit> hits) const {
  constexpr size_t kCacheBytes = 256 * 1024; // what is smaller stays in the second-level cache
  if (statistics_.geometry_bytes + statistics_.texture_bytes <= kCacheBytes) return;
  for (const accel::Hit& hit : hits) {
    if (hit.is_hit()) ::kindling::prefetch(geometries_[hit.mesh].indices.data() + size_t{hit.triangle} * 3);
  }
  for (const accel::Hit& hit : hits) {
    if (!hit.is_hit()) continue;
    const Geometry& geometry = geometries_[hit.mesh];
    const uint32_t* index = geometry.indices.data() + size_t{hit.triangle} * 3;
    for (size_t corner = 0; corner < 3; ++corner) {
      ::kindling::prefetch(&geometry.positions[index[corner]]);
      const float* record = geometry.record(index[corner]);
      ::kindling::prefetch(record);
      if (geometry.stride > 0) ::kindling::prefetch(record + geometry.stride - 1);
    }
  }
  if (textures_.empty()) return;
  for (const accel::Hit& hit : hits) {
    if (!hit.is_hit()) continue;
    const Geometry& geometry = geometries_[hit.mesh];
    prefetch_textures(materials_[geometry.material], HitRecords(geometry, hit), textures_);
  }
}

} // namespace kindling
