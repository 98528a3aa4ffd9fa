// Reads one graph of KHR_texture_procedurals from unchecked JSON.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/texture/procedural_graph.h"

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <string_view>

namespace kindling::gltf {

// A fault of a graph with its place.
struct ProceduralFault {
  std::string pointer;
  std::string message;
};

// `pointer` is the graph's place in the file; filename inputs refer to one of `texture_count`
// textures. Throws ProceduralFault.
[[nodiscard]] ProceduralGraph read_procedural_graph(const nlohmann::json& graph, const std::string& pointer,
                                                    size_t texture_count);

} // namespace kindling::gltf
