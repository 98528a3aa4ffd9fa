// What a World hands on to the next one of the same scene: prepared textures, the vertices of what stands where it stood, and what the
// accelerator has built over them.
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

// All that an undeformed primitive's Geometry depends on, in a scene whose vertices stay what they are.
struct GeometryKey {
  int mesh = kNone; // kNone: deformed, nobody else has it
  uint32_t primitive = 0;
  uint32_t material = 0;
  uint64_t layout = 0; // geometry_layout() of the material
  M44f bake;
  bool operator==(const GeometryKey&) const = default;
};

// What decides which attributes vertices keep: the sets of texture coordinates that the material reads, and whether it wants tangents.
[[nodiscard]] uint64_t geometry_layout(const Material& material);

// Geometries that wait for somebody who needs the same again.
class GeometryStore {
 public:
  void put(const GeometryKey& key, Geometry&& geometry);
  [[nodiscard]] std::optional<Geometry> take(const GeometryKey& key);
  void clear() { geometries_.clear(); }

 private:
  // By mesh and primitive; equal ones go in the order in which they came, so that each goes to where it was.
  std::map<std::pair<int, uint32_t>, std::list<std::pair<GeometryKey, Geometry>>> geometries_;
};

struct WorldParts {
  bool keep_scene = false; // another World will be built from it
  std::vector<uint8_t>
      still; // then, by mesh: its arrays may be consumed all the same, because what is made of them is handed on for good

  std::vector<GeometryKey> keys; // of the World's geometries
  GeometryStore geometries;
  uint64_t geometry_count = 0;                               // made so far
  std::unique_ptr<accel::PersistentStructures> accelerators; // over them; null: none
  TextureTable::Numbers texture_numbers;
  std::optional<std::vector<Texture>> textures; // with these numbers
  size_t texture_bytes = 0;
};

// build_world() with parts of an earlier World, which notes what its own parts are.
[[nodiscard]] Result<std::unique_ptr<World>> build_world_of_parts(Scene& scene, PosedScene posed,
                                                                  const WorldOptions& options, WorldParts& parts,
                                                                  const CancelToken* cancel,
                                                                  ProgressListener* listener);

// Takes what can be handed on; the World is of no use any more.
void take_parts(std::unique_ptr<World> world, WorldParts& parts);

} // namespace kindling
