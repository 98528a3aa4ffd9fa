// Collects vertices and polygons of a file into one list of triangles, within the limits.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/failure.h"
#include "renderer/import/files/import_limits.h"
#include "renderer/scene/scene.h"

#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>

namespace kindling::polygons {

// Errors are ImportFailure, as everywhere in the importer.
class PolygonBuilder {
 public:
  PolygonBuilder(const ImportLimits& limits, gltf::Warnings& warnings) : limits_(limits), warnings_(warnings) {}

  // Counts what a file declares against ImportLimits::max_total_elements, before it is read.
  void charge(uint64_t elements, const std::string& place);

  // Adds a vertex and returns its index. Those with a coordinate that is not finite lose their
  // triangles at the end.
  uint32_t add_vertex(const V3f& position);
  // The same for files without shared vertices: equal positions, to the bit, have one index.
  uint32_t add_shared_vertex(const V3f& position);
  // Adds a polygon as a fan of triangles. Corners must be below the number of vertices. Those of
  // less than three corners are left out, with a warning.
  void add_polygon(std::span<const uint32_t> corners, const std::string& place);

  [[nodiscard]] Primitive& primitive() { return primitive_; }
  // Checks, and hands the triangles over. Fails if there are none.
  [[nodiscard]] Primitive finish();

 private:
  struct PositionHash {
    size_t operator()(const std::array<uint32_t, 3>& bits) const;
  };

  const ImportLimits& limits_;
  gltf::Warnings& warnings_;
  Primitive primitive_;
  std::unordered_map<std::array<uint32_t, 3>, uint32_t, PositionHash> shared_;
  uint64_t elements_ = 0;
};

} // namespace kindling::polygons
