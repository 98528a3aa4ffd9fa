// Checks the accessors of a primitive before it is read.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/accessor.h"

#include <string>
#include <string_view>

namespace kindling::gltf {

[[nodiscard]] std::string primitive_pointer(size_t mesh, size_t primitive);

// Returns 3 for "TEXCOORD_3" with prefix "TEXCOORD_"; -1 for other names.
[[nodiscard]] int set_number(std::string_view name, std::string_view prefix);

// Returns the number of sets with both joints and weights.
[[nodiscard]] int joint_sets(const tinygltf::Primitive& core);

// Checks formats and counts of all accessors that the primitive refers to and charges the budget
// for what read_primitive() will decode. Unless `warnings` is strict, removes faulty attributes
// that a surface can do without (normals, tangents, colors, texture coordinates, morph targets)
// from the document; attributes with excess elements stay. Throws ImportFailure. Not thread-safe.
void check_primitive(Document& document, size_t mesh, size_t primitive, ElementBudget& budget, Warnings& warnings);

} // namespace kindling::gltf
