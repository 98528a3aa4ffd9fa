// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/leaf_block.h"

#include <cstring>

namespace kindling::accel::kd {
namespace {

// Collects triangles until one of the limits is met.
class BlockBuilder {
 public:
  // False if the triangle does not fit any more.
  bool add(const Geometry& geometry, uint32_t triangle) {
    if (triangles_ == kBlockTriangles) return false;
    const uint32_t before = vertices_;
    uint32_t corners = 0;
    for (uint32_t corner = 0; corner < 3; ++corner) {
      const uint32_t vertex = number_of(geometry.vertex(triangle, static_cast<int>(corner)));
      if (vertex == kBlockVertices) {
        vertices_ = before;
        return false;
      }
      corners |= vertex << (4 * corner);
    }
    corners_[triangles_] = static_cast<uint16_t>(corners);
    primitives_[triangles_] = geometry.first_primitive + triangle;
    asking_ |= (geometry.mesh.opaque ? 0U : 1U) << triangles_;
    ++triangles_;
    return true;
  }

  // Appends the block and starts the next.
  void finish(bool more, std::vector<LeafUnit>& out) {
    const size_t first = out.size();
    out.resize(first + LeafBlock::units_for(vertices_, triangles_), LeafUnit{});
    uint32_t* words = out[first].words.data();
    words[0] = vertices_ | triangles_ << 5 | (more ? LeafBlock::kMore : 0U) | asking_ << 16;
    for (uint32_t axis = 0; axis < 3; ++axis)
      std::memcpy(words + 1 + axis * vertices_, position_[axis].data(), vertices_ * sizeof(uint32_t));
    std::memcpy(words + 1 + 3 * vertices_, corners_.data(), triangles_ * sizeof(uint16_t));
    std::memcpy(words + 1 + 3 * vertices_ + (triangles_ + 1) / 2, primitives_.data(), triangles_ * sizeof(uint32_t));
    vertices_ = triangles_ = asking_ = 0;
  }

 private:
  // The place of a position among the vertices, where it is put if it is new; kBlockVertices: there is no room.
  uint32_t number_of(const Imath::V3f& p) {
    uint32_t bits[3];
    std::memcpy(bits, &p, sizeof(bits));
    for (uint32_t i = 0; i < vertices_; ++i)
      if (position_[0][i] == bits[0] && position_[1][i] == bits[1] && position_[2][i] == bits[2]) return i;
    if (vertices_ == kBlockVertices) return kBlockVertices;
    for (uint32_t axis = 0; axis < 3; ++axis) position_[axis][vertices_] = bits[axis];
    return vertices_++;
  }

  std::array<std::array<uint32_t, kBlockVertices>, 3> position_; // by axis, as bits
  std::array<uint16_t, kBlockTriangles> corners_{};
  std::array<uint32_t, kBlockTriangles> primitives_{};
  uint32_t vertices_ = 0, triangles_ = 0, asking_ = 0;
};

} // namespace

void append_leaf(std::span<const Geometry> geometries, std::span<const LeafReference> references,
                 std::vector<LeafUnit>& out) {
  BlockBuilder block;
  const auto add = [&](const LeafReference& r) { return block.add(geometries[r.geometry], r.triangle); };
  // What does not fit into a block waits for the next: later triangles may still share the vertices that are there.
  std::vector<LeafReference> waiting;
  for (const LeafReference& reference : references)
    if (!add(reference)) waiting.push_back(reference);
  while (!waiting.empty()) {
    block.finish(true, out);
    std::erase_if(waiting, add);
  }
  block.finish(false, out);
}

} // namespace kindling::accel::kd
