// Triangle lists from glTF's primitive modes, and the vertices that they use. All of it runs in parallel with TBB, and gives the same for
// any number of threads.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace kindling::gltf {

inline constexpr int kModeTriangles = 4;
inline constexpr int kModeStrip = 5;
inline constexpr int kModeFan = 6;

// How many corners the list of a primitive with `count` indices (or vertices) has.
[[nodiscard]] uint64_t triangle_list_size(uint64_t count, int mode);

// Unrolled as glTF 2.0, section 3.7.2.1, orders the corners; stray indices at the end are dropped.
[[nodiscard]] std::vector<uint32_t> to_triangle_list(std::vector<uint32_t> indices, int mode);

// The place of the first index that is not below `vertex_count`, if there is one.
[[nodiscard]] std::optional<size_t> first_out_of_bounds(std::span<const uint32_t> indices, uint32_t vertex_count);

// If `indices` use fewer than all vertices, makes them count only the used ones, in their old order, and returns which
// those are; else returns nothing. Exporters let many primitives share one long list of vertices.
[[nodiscard]] std::vector<uint32_t> compact_vertices(std::vector<uint32_t>& indices, uint32_t vertex_count);

} // namespace kindling::gltf
