// One primitive of a mesh: accessors to the arrays of a Primitive.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/accessor.h"
#include "renderer/scene/scene.h"

#include <optional>
#include <span>
#include <string>

namespace kindling::gltf {

// Reads a primitive that check_primitive() has passed. Points and lines become
// triangles without extent (Primitive::stroke). Returns nothing, with a warning, for primitives
// without positions or bodies. `materials` are those that the primitive may
// have, its own first, null for the default one; tangents are read if one of them needs any. Throws
// ImportFailure. Thread-safe.
[[nodiscard]] std::optional<Primitive> read_primitive(const Document& document, size_t mesh, size_t primitive,
                                                      std::span<const Material* const> materials, Warnings& warnings);

// Computes missing tangents of a primitive from read_primitive() if one of its materials needs
// them. Thread-safe.
void make_missing_tangents(size_t mesh, size_t index, std::span<const Material* const> materials, Primitive& primitive,
                           Warnings& warnings);

} // namespace kindling::gltf
