// Encodes deforming triangles as leaf blocks with shared vertices.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/deforming/moving_block.h"

#include "accel/kdtree/triangle_packer.h"
#include "accel/motion.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>

namespace kindling::accel::kd {
namespace {

// The keys of a mesh that the times of a slice need.
struct KeyRange {
  uint32_t segments = 0, first = 0, count = 0;

  KeyRange() = default;
  KeyRange(const TriangleMesh& mesh, const TimeSlice& slice) : segments(key_count(mesh) - 1) {
    first = key_interval(slice.begin, segments).first;
    const float last_time =
        slice.end < 1.0f ? std::nextafter(slice.end, 0.0f) : 1.0f; // the end belongs to the next slice
    count = key_interval(last_time, segments).first + 2 - first;
  }
  friend bool operator==(const KeyRange&, const KeyRange&) = default;
};

// Collects triangles until the block is full or a triangle has other keys.
class MovingBlockBuilder {
 public:
  explicit MovingBlockBuilder(const TimeSlice& slice) : slice_(slice) {}

  bool add(const Geometry& geometry, uint32_t triangle) {
    if (triangles_.count() == kBlockTriangles) return false;
    const KeyRange keys(geometry.mesh, slice_);
    if (triangles_.count() != 0 && keys != keys_) return false;
    keys_ = keys;
    const uint32_t before = vertices_;
    uint32_t corners = 0;
    for (uint32_t corner = 0; corner < 3; ++corner) {
      const uint32_t vertex =
          number_of(geometry.mesh, geometry.mesh.indices[3 * static_cast<size_t>(triangle) + corner]);
      if (vertex == kBlockVertices) {
        vertices_ = before;
        return false;
      }
      corners |= vertex << (4 * corner);
    }
    triangles_.add(corners, geometry.first_primitive + triangle, geometry.mesh.opaque);
    return true;
  }

  // Appends the block to `out` and starts the next.
  void finish(bool more, std::vector<LeafUnit>& out) {
    const size_t first = out.size();
    out.resize(first + MovingBlock::units_for(vertices_, triangles_.word_count(), keys_.count), LeafUnit{});
    uint32_t* words = out[first].words.data();
    *words++ = vertices_ | (more ? 1U : 0U) << LeafBlock::kNextShift | triangles_.header();
    *words++ = keys_.segments | keys_.first << 8 | keys_.count << 16;
    for (uint32_t key = 0; key < keys_.count; ++key)
      for (int axis = 0; axis < 3; ++axis)
        for (uint32_t i = 0; i < vertices_; ++i) std::memcpy(words++, &position(i, key)[axis], sizeof(float));
    triangles_.write(words);
    vertices_ = 0;
    triangles_.clear();
  }

 private:
  struct Vertex {
    const TriangleMesh* mesh;
    uint32_t number;
    Imath::V3f at_first; // position at the first key
  };

  [[nodiscard]] const Imath::V3f& position(uint32_t i, uint32_t key) const {
    return positions_at_key(*vertex_[i].mesh, keys_.first + key)[vertex_[i].number];
  }
  [[nodiscard]] static bool is_same(const Imath::V3f& a, const Imath::V3f& b) {
    return std::memcmp(&a, &b, sizeof(Imath::V3f)) == 0;
  }
  // Returns the index of a vertex, added if new; kBlockVertices if the block is full. Vertices with
  // equal positions at all keys are shared.
  uint32_t number_of(const TriangleMesh& mesh, uint32_t number) {
    for (uint32_t i = 0; i < vertices_; ++i)
      if (vertex_[i].number == number && vertex_[i].mesh == &mesh) return i;
    const Imath::V3f at_first = positions_at_key(mesh, keys_.first)[number];
    for (uint32_t i = 0; i < vertices_; ++i) {
      bool same = is_same(vertex_[i].at_first, at_first);
      for (uint32_t key = 1; same && key < keys_.count; ++key)
        same = is_same(position(i, key), positions_at_key(mesh, keys_.first + key)[number]);
      if (same) return i;
    }
    if (vertices_ == kBlockVertices) return kBlockVertices;
    vertex_[vertices_] = {&mesh, number, at_first};
    return vertices_++;
  }

  TimeSlice slice_;
  KeyRange keys_;
  std::array<Vertex, kBlockVertices> vertex_;
  TrianglePacker triangles_;
  uint32_t vertices_ = 0;
};

// Appends the blocks of some references of a leaf; `more`: others follow.
void append_moving_blocks(std::span<const Geometry> geometries, std::span<const LeafReference> references,
                          const TimeSlice& slice, bool more, std::vector<LeafUnit>& out) {
  MovingBlockBuilder block(slice);
  const auto add = [&](const LeafReference& r) { return block.add(geometries[r.geometry], r.triangle); };
  std::vector<LeafReference> waiting; // triangles that do not fit wait for the next block
  for (const LeafReference& reference : references)
    if (!add(reference)) waiting.push_back(reference);
  while (!waiting.empty()) {
    block.finish(true, out);
    waiting.erase(std::remove_if(waiting.begin(), waiting.end(), add), waiting.end());
  }
  block.finish(more, out);
}

} // namespace

void append_moving_leaf(std::span<const Geometry> geometries, std::span<const LeafReference> references,
                        const TimeSlice& slice, std::vector<LeafUnit>& out) {
  assert(!references.empty());
  for_each_leaf_part(references, [&](std::span<const LeafReference> part, bool more) {
    append_moving_blocks(geometries, part, slice, more, out);
  });
}

} // namespace kindling::accel::kd
