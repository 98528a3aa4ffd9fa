// Triangle lists from glTF's primitive modes, and removal of unused vertices.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace kindling::gltf {

// All functions run in parallel with TBB; results do not depend on the number of threads.

inline constexpr int kModeTriangles = 4;
inline constexpr int kModeStrip = 5;
inline constexpr int kModeFan = 6;

// Returns the length of the triangle list of a primitive with `count` indices (or vertices).
[[nodiscard]] uint64_t triangle_list_size(uint64_t count, int mode);

// Converts indices of `mode` to a triangle list (corner order: glTF 2.0, section 3.7.2.1). Drops
// incomplete triangles at the end.
[[nodiscard]] std::vector<uint32_t> to_triangle_list(std::vector<uint32_t> indices, int mode);

// Returns the position of the first index that is not below `vertex_count`, if there is one.
[[nodiscard]] std::optional<size_t> first_out_of_bounds(std::span<const uint32_t> indices, uint32_t vertex_count);

// If some vertices are unused, renumbers `indices` to count the used ones alone, in their old
// order, and returns the old indices of these; else returns an empty list. Exporters let many
// primitives share one long list of vertices.
[[nodiscard]] std::vector<uint32_t> compact_vertices(std::vector<uint32_t>& indices, uint32_t vertex_count);

} // namespace kindling::gltf
