// The textures of a scene's materials; each image is prepared once per content type.
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

// Textures are numbered while materials are bound, then all of them are built at once, in parallel.
class TextureTable {
 public:
  // Keys are the scene's texture index and the content.
  using Numbers = std::map<std::pair<int, TextureContent>, int32_t>;

  // Borrows the arguments until build() returns.
  explicit TextureTable(std::span<const SceneTexture> sources, std::span<const ProceduralGraph> graphs = {})
      : sources_(sources), graphs_(graphs) {}

  // Returns the index in build()'s result of texture `source` of the scene, read as `content`;
  // kNone if it has no image.
  [[nodiscard]] int32_t number_of(int source, TextureContent content);
  // The same for an output of a graph: below kNone (TextureBinding::procedural()).
  [[nodiscard]] int32_t number_of_procedural(int graph, int output);

  // Builds all numbered textures. `bytes` is set to the memory of all images and their levels,
  // shared ones once. The result does not depend on the number of threads. If the budget of
  // `memory` (may be null) is exceeded, all textures are paged: it must outlive them, and paging
  // may fail.
  [[nodiscard]] Result<std::vector<Texture>> build(TextureMemory* memory, size_t& bytes) const;
  // The same numbers for the same scene give the same textures.
  [[nodiscard]] const Numbers& numbers() const { return numbers_; }
  // Returns the numbered procedural textures; call once.
  [[nodiscard]] std::vector<ProceduralTexture> take_procedurals() { return std::move(procedurals_); }

 private:
  std::span<const SceneTexture> sources_;
  std::span<const ProceduralGraph> graphs_;
  Numbers numbers_;
  std::map<std::pair<int, int>, int32_t> procedural_numbers_; // by graph and output
  std::vector<ProceduralTexture> procedurals_;
};

} // namespace kindling
