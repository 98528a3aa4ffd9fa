// Adds polygons, and leaves out what cannot be rendered.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/polygons/polygon_builder.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>

namespace kindling::polygons {

namespace {

// Beyond it products of coordinates overflow (accel/triangle.h).
constexpr float kMaxCoordinate = 1.8e18f;

bool is_usable(const V3f& p) {
  return std::fabs(p.x) <= kMaxCoordinate && std::fabs(p.y) <= kMaxCoordinate && std::fabs(p.z) <= kMaxCoordinate;
}

} // namespace

size_t PolygonBuilder::PositionHash::operator()(const std::array<uint32_t, 3>& bits) const {
  uint64_t hash = 0xcbf29ce484222325ULL;
  for (const uint32_t word : bits) {
    hash = (hash ^ word) * 0x9e3779b97f4a7c15ULL;
    hash ^= hash >> 32;
  }
  return hash;
}

void PolygonBuilder::charge(uint64_t elements, const std::string& place) {
  if (elements > limits_.max_total_elements - elements_)
    gltf::fail(place, fmt::format("{} elements, at most {} are accepted in all", elements, limits_.max_total_elements));
  elements_ += elements;
}

uint32_t PolygonBuilder::add_vertex(const V3f& position) {
  constexpr size_t kMaxVertices = 0xfffffffeU;
  if (primitive_.positions.size() >= kMaxVertices) gltf::fail("", fmt::format("more than {} vertices", kMaxVertices));
  primitive_.positions.push_back(position);
  return static_cast<uint32_t>(primitive_.positions.size() - 1);
}

uint32_t PolygonBuilder::add_shared_vertex(const V3f& position) {
  // -0 and 0 are one place.
  const std::array<uint32_t, 3> bits{std::bit_cast<uint32_t>(position.x + 0.0f),
                                     std::bit_cast<uint32_t>(position.y + 0.0f),
                                     std::bit_cast<uint32_t>(position.z + 0.0f)};
  const auto [found, is_new] = shared_.try_emplace(bits, 0);
  if (is_new) found->second = add_vertex(position);
  return found->second;
}

void PolygonBuilder::add_polygon(std::span<const uint32_t> corners, const std::string& place) {
  if (corners.size() < 3) {
    warnings_.repair("polygon", place, fmt::format("a polygon of {} corners", corners.size()), "", "it is left out");
    return;
  }
  for (size_t i = 2; i < corners.size(); ++i)
    primitive_.indices.insert(primitive_.indices.end(), {corners[0], corners[i - 1], corners[i]});
}

Primitive PolygonBuilder::finish() {
  std::vector<V3f>& positions = primitive_.positions;
  size_t bad = 0, first_bad = 0;
  std::vector<bool> usable(positions.size(), true);
  for (size_t i = 0; i < positions.size(); ++i) {
    if (is_usable(positions[i])) continue;
    if (bad++ == 0) first_bad = i;
    usable[i] = false;
    positions[i] = V3f(0.0f);
  }
  if (bad > 0) {
    warnings_.repair("position", fmt::format("vertex {}", first_bad),
                     fmt::format("{} of {} positions are not finite", bad, positions.size()), "",
                     "their triangles are left out");
    std::vector<uint32_t> remaining;
    for (size_t i = 0; i + 2 < primitive_.indices.size(); i += 3) {
      const uint32_t* corner = &primitive_.indices[i];
      if (usable[corner[0]] && usable[corner[1]] && usable[corner[2]])
        remaining.insert(remaining.end(), corner, corner + 3);
    }
    primitive_.indices = std::move(remaining);
  }
  if (primitive_.indices.empty())
    gltf::fail("", positions.empty()
                       ? "no vertices and no polygons; a mesh of triangles or polygons is needed"
                       : "vertices without polygons (a point cloud?); a mesh of triangles or polygons is needed");
  bool unit = true;
  for (V3f& normal : primitive_.normals) {
    const float length = normal.length();
    unit = unit && std::isfinite(length) && length > 0.0f;
    if (unit) normal /= length;
  }
  if (!unit) {
    warnings_.repair("normal", "", "normals of no length, or not finite", "", "faces are flat");
    primitive_.normals.clear();
  }
  shared_.clear();
  return std::move(primitive_);
}

} // namespace kindling::polygons
