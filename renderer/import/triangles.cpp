// Unrolling and compacting of indices.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/triangles.h"

#include <algorithm>

namespace kindling::gltf {

uint64_t triangle_list_size(uint64_t count, int mode) {
  if (mode == kModeTriangles) return count - count % 3;
  return count < 3 ? 0 : (count - 2) * 3;
}

std::vector<uint32_t> to_triangle_list(std::vector<uint32_t> indices, int mode) {
  const uint64_t size = triangle_list_size(indices.size(), mode);
  if (mode == kModeTriangles) {
    indices.resize(size);
    return indices;
  }
  std::vector<uint32_t> list;
  list.reserve(size);
  for (size_t i = 0; i < size / 3; ++i) {
    if (mode == kModeFan) {
      list.insert(list.end(), {indices[i + 1], indices[i + 2], indices[0]});
    } else {
      list.insert(list.end(), {indices[i], indices[i + 1 + i % 2], indices[i + 2 - i % 2]});
    }
  }
  return list;
}

std::vector<uint32_t> compact_vertices(std::vector<uint32_t>& indices, uint32_t vertex_count) {
  if (indices.empty()) return {};
  const auto [min, max] = std::minmax_element(indices.begin(), indices.end());
  const uint32_t first = *min;
  // Only over the range in use: many small primitives may share one long list.
  std::vector<uint32_t> number(*max - first + 1, 0);
  for (const uint32_t index : indices) number[index - first] = 1;
  std::vector<uint32_t> used;
  used.reserve(std::min(number.size(), indices.size()));
  for (uint32_t i = 0; i < number.size(); ++i) {
    if (number[i] == 0) continue;
    number[i] = static_cast<uint32_t>(used.size());
    used.push_back(first + i);
  }
  if (used.size() == vertex_count) return {};
  for (uint32_t& index : indices) index = number[index - first];
  return used;
}

} // namespace kindling::gltf
