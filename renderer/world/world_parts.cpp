// Storage of geometries that later Worlds can reuse.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/world_parts.h"

#include "renderer/scene/material_slots.h"
#include "renderer/scene/tangents.h"

#include <algorithm>

namespace kindling {

uint64_t geometry_layout(const Material& material) {
  uint32_t sets = 0;
  for (const TextureSlot* slot : texture_slots(material)) sets |= slot->texcoord_sets();
  return (uint64_t{sets} << 1U) | (tangent_texcoord_set(material) ? 1U : 0U);
}

void GeometryStore::put(const GeometryKey& key, Geometry&& geometry) {
  if (key.mesh != kNone) geometries_[{key.mesh, key.primitive}].emplace_back(key, std::move(geometry));
}

std::optional<Geometry> GeometryStore::take(const GeometryKey& key) {
  const auto entry = geometries_.find({key.mesh, key.primitive});
  if (entry == geometries_.end()) return std::nullopt;
  auto& stored = entry->second;
  const auto found = std::find_if(stored.begin(), stored.end(), [&](const auto& one) { return one.first == key; });
  if (found == stored.end()) return std::nullopt;
  std::optional<Geometry> geometry(std::move(found->second));
  stored.erase(found);
  return geometry;
}

} // namespace kindling
