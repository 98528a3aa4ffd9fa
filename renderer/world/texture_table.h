// The textures that the materials of a scene refer to, each image prepared once for each thing it stands for.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/scene/scene.h"
#include "renderer/texture/procedural_texture.h"
#include "renderer/texture/texture.h"
#include "renderer/texture/texture_memory.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

namespace kindling {

// Numbers first, while materials are bound; then all of them are built at once, in parallel.
class TextureTable {
 public:
  // What they are numbered by: texture of the scene, content.
  using Numbers = std::map<std::pair<int, TextureContent>, int32_t>;

  // Borrows them until build() returns.
  explicit TextureTable(std::span<const SceneTexture> sources, std::span<const ProceduralGraph> graphs = {})
      : sources_(sources), graphs_(graphs) {}

  // Where texture `source` of the scene, read as `content`, will stand in what build() gives; kNone if it has no image.
  [[nodiscard]] int32_t number_of(int source, TextureContent content);
  // The same for an output of a graph: below kNone (TextureBinding::procedural()).
  [[nodiscard]] int32_t number_of_procedural(int graph, int output);

  // `bytes`: of all images and their levels in memory, shared ones once. The result does not depend on the number of threads.
  // Where `memory` (may be null) is exceeded, all are paged: it must outlive the textures, and may fail.
  [[nodiscard]] Result<std::vector<Texture>> build(TextureMemory* memory, size_t& bytes) const;
  // The same numbers of the same scene give the same textures.
  [[nodiscard]] const Numbers& numbers() const { return numbers_; }
  // Those that have been numbered; once.
  [[nodiscard]] std::vector<ProceduralTexture> take_procedurals() { return std::move(procedurals_); }

 private:
  std::span<const SceneTexture> sources_;
  std::span<const ProceduralGraph> graphs_;
  Numbers numbers_;
  std::map<std::pair<int, int>, int32_t> procedural_numbers_; // of graph and output
  std::vector<ProceduralTexture> procedurals_;
};

} // namespace kindling
