// KHR_draco_mesh_compression: one primitive's triangles and attributes, decompressed and validated.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/accessor.h"

#include <cstdint>
#include <string>
#include <vector>

namespace kindling::gltf {

struct DracoAttribute {
  std::string semantic;
  OwnedBytes bytes;  // in the accessor's component type, tightly packed
  AccessorView view; // of `bytes`
};

struct DracoPrimitive {
  std::vector<uint32_t> indices; // triangle list, every index below vertex_count
  uint32_t vertex_count = 0;
  std::vector<DracoAttribute> attributes;
};

struct DracoCounts {
  uint64_t faces = 0;
  uint64_t vertices = 0;
};

// Returns the extension object of a primitive, or null.
[[nodiscard]] const nlohmann::json* find_draco(const Document& document, size_t mesh, size_t primitive);

// Reads the declared counts from the header (Draco bitstream 2.2), so that a file above the limits
// is refused before libdraco allocates. Throws ImportFailure.
[[nodiscard]] DracoCounts declared_draco_counts(const Document& document, const nlohmann::json& draco,
                                                const std::string& pointer);

// Decodes a primitive. Attributes have the types and components of their accessors, whose counts
// are ignored. Throws ImportFailure.
[[nodiscard]] DracoPrimitive decode_draco(const Document& document, const nlohmann::json& draco,
                                          const tinygltf::Primitive& primitive, const std::string& pointer);

} // namespace kindling::gltf
