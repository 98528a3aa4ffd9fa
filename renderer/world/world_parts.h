// Parts that a World passes on to the next one of the same scene.
// Prepared textures, unchanged vertices, and acceleration structures over them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/texture/texture.h"
#include "renderer/world/build_world.h"
#include "renderer/world/geometry.h"
#include "renderer/world/texture_table.h"

#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace kindling {

// Everything that an undeformed primitive's Geometry depends on, in a scene with constant vertices.
struct GeometryKey {
  int mesh = kNone; // kNone: deformed, unique
  uint32_t primitive = 0;
  uint32_t material = 0;
  uint64_t layout = 0; // geometry_layout() of the material
  M44f bake;
  bool operator==(const GeometryKey&) const = default;
};

// Returns a number for the vertex attributes to keep: the texture coordinate sets that the material
// reads, and whether it needs tangents.
[[nodiscard]] uint64_t geometry_layout(const Material& material);

// Geometries that are available for reuse.
class GeometryStore {
 public:
  void put(const GeometryKey& key, Geometry&& geometry);
  [[nodiscard]] std::optional<Geometry> take(const GeometryKey& key);
  void clear() { geometries_.clear(); }

 private:
  // By mesh and primitive; equal ones are reused in their order of insertion, so that each returns
  // to its place.
  std::map<std::pair<int, uint32_t>, std::list<std::pair<GeometryKey, Geometry>>> geometries_;
};

struct WorldParts {
  bool keep_scene = false; // another World will be built from it
  // By mesh, with keep_scene: its arrays may still be consumed, because its geometry is always
  // reused.
  std::vector<uint8_t> static_meshes;

  std::vector<GeometryKey> keys; // of the World's geometries
  GeometryStore geometries;
  uint64_t geometry_count = 0;                               // geometries made so far
  std::unique_ptr<accel::PersistentStructures> accelerators; // over the geometries; null: none
  TextureTable::Numbers texture_numbers;
  std::optional<std::vector<Texture>> textures; // with these numbers
  size_t texture_bytes = 0;
};

// build_world() that reuses the parts of an earlier World and stores its own parts.
[[nodiscard]] Result<std::unique_ptr<World>> build_world_of_parts(Scene& scene, PosedScene posed,
                                                                  const WorldOptions& options, WorldParts& parts,
                                                                  const CancelToken* cancel,
                                                                  ProgressListener* listener);

// Takes the reusable parts; the World must not be used afterwards.
void take_parts(std::unique_ptr<World> world, WorldParts& parts);

} // namespace kindling
