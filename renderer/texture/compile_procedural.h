// From a graph of nodes to instructions: constants folded, dead code left out, patterns that can filter themselves marked.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/texture/procedural_graph.h"
#include "renderer/texture/procedural_program.h"
#include "renderer/texture/procedural_texture.h"

#include <vector>

namespace kindling {

struct CompiledProcedural {
  ProceduralProgram program;
  std::vector<ProceduralStream> streams;
};

// Output number `output` of a sound graph.
[[nodiscard]] CompiledProcedural compile_procedural(const ProceduralGraph& graph, size_t output,
                                                    const ProceduralTexture::TextureNumber& number_of);

} // namespace kindling
