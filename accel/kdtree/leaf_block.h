// Leaf blocks: up to 16 triangles with up to 16 shared vertices.
//
// The triangles of a leaf are neighbors: ten of them have about ten vertices, not thirty. Storing
// each vertex once at least halves the memory, and a ray is translated and sheared to each vertex
// once before the triangles select theirs by permutation. The arithmetic for a triangle is the same
// as if its vertices were stored separately. leaf_format.h has the layout.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/binary_tree.h"
#include "accel/kdtree/build/reference.h"
#include "accel/kdtree/leaf_format.h"

#include <cstddef>
#include <span>
#include <vector>

namespace kindling::accel::kd {

// Calls append(part, more) for the parts of a leaf that are encoded one after the other; `more` is
// false for the last one. Each block tries all references of its part that are left, so without
// parts the time would grow with the square of the leaf. Ordinary leaves are one part.
inline constexpr size_t kMaxLeafPart = 2048;
template <class Append>
void for_each_leaf_part(std::span<const LeafReference> references, const Append& append) {
  for (; references.size() > kMaxLeafPart; references = references.subspan(kMaxLeafPart))
    append(references.first(kMaxLeafPart), true);
  append(references, false);
}

// Appends the blocks of a leaf, which must have at least one reference.
void append_leaf(std::span<const Geometry> geometries, std::span<const LeafReference> references,
                 std::vector<LeafUnit>& out);

} // namespace kindling::accel::kd
