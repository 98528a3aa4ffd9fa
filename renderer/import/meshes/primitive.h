// One primitive of a mesh: its accessors become the arrays of a Primitive.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/accessor.h"
#include "renderer/scene/scene.h"

#include <optional>
#include <span>
#include <string>

namespace kindling::gltf {

// Checks formats and counts of all accessors that the primitive refers to and charges the budget for what
// read_primitive() will decode. Throws ImportFailure. Not thread-safe (the budget).
void check_primitive(const Document& document, size_t mesh, size_t primitive, ElementBudget& budget);

// Nothing for points, lines and primitives without positions or triangles: a warning. `materials` are those that it may have, its
// own first and none for the default one; they decide whether tangents are kept. Throws ImportFailure. Thread-safe.
[[nodiscard]] std::optional<Primitive> read_primitive(const Document& document, size_t mesh, size_t primitive,
                                                      std::span<const Material* const> materials, Warnings& warnings);

// Makes tangents of what read_primitive() gave, where one of the materials needs them and there are none. Thread-safe.
void make_missing_tangents(size_t mesh, size_t index, std::span<const Material* const> materials, Primitive& primitive,
                           Warnings& warnings);

} // namespace kindling::gltf
