// Compiler from procedural graphs to instructions, with constant folding and dead-code elimination.
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

// Compiles output number `output` of a valid graph, and marks the patterns that are filtered
// analytically.
[[nodiscard]] CompiledProcedural compile_procedural(const ProceduralGraph& graph, size_t output,
                                                    const ProceduralTexture::TextureNumber& number_of);

} // namespace kindling
