// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/partition.h"

#include "accel/kdtree/clipping.h"
#include "accel/kdtree/lanes.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace kindling::accel::kd {
namespace {

constexpr size_t kChunk = 16384; // fixed, so that results do not depend on the number of threads

// Copies as one register; Imath's vectors would be copied by component.
void copy(const Reference& from, Reference* to) { store_lanes(to, load_lanes<Int8Lanes>(&from)); }

// Writes each reference to the end of its list, and of the others, where the next will overwrite it: no branches.
struct Lists {
  Reference *left, *right, *cut;
};
Lists deal(const Reference* references, size_t count, const Split& split, Lists lists) {
  const size_t axis = static_cast<size_t>(split.axis);
  for (size_t i = 0; i < count; ++i) {
    const auto lanes = load_lanes<Int8Lanes>(references + i);
    const float* bounds = &references[i].min.x;
    const bool below = bounds[axis] <= split.position, above = bounds[axis + 4] >= split.position;
    const bool ends_below = bounds[axis + 4] <= split.position, starts_above = bounds[axis] >= split.position;
    const bool planar = ends_below && starts_above;
    const bool left = ends_below && (!planar || split.planar_left);
    const bool right = starts_above && !left;
    const bool cut = below && above && !left && !right;
    store_lanes(lists.left, lanes);
    store_lanes(lists.right, lanes);
    store_lanes(lists.cut, lanes);
    lists.left += left ? 1 : 0;
    lists.right += right ? 1 : 0;
    lists.cut += cut ? 1 : 0;
  }
  return lists;
}

void cut_all(std::span<const Geometry> geometries, std::span<const Reference> references, const Split& split,
             Reference*& left, Reference*& right) {
  for (const Reference& reference : references) {
    const SplitReference parts = split_reference(geometries, reference, split.axis, split.position);
    if (parts.in_left) copy(parts.left, left++);
    if (parts.in_right) copy(parts.right, right++);
  }
}

} // namespace

void ReferenceBuffer::reserve(size_t size, size_t keep) {
  if (size <= capacity_) return;
  size = std::max(size, capacity_ + capacity_ / 2);
  auto items = std::make_unique_for_overwrite<Reference[]>(size);
  std::copy_n(items_.get(), keep, items.get());
  items_ = std::move(items);
  capacity_ = size;
}

HalfCounts partition_in_place(std::span<const Geometry> geometries, Reference* references, size_t count,
                              const Split& split, bool left_in_place, Reference* elsewhere, ReferenceBuffer& scratch) {
  scratch.reserve(count + 1, 0);
  const Lists first = {left_in_place ? references : elsewhere, left_in_place ? elsewhere : references, scratch.data()};
  Lists end = deal(references, count, split, first);
  cut_all(geometries, {first.cut, end.cut}, split, end.left, end.right);
  return {static_cast<size_t>(end.left - first.left), static_cast<size_t>(end.right - first.right)};
}

Halves partition_in_chunks(std::span<const Geometry> geometries, std::span<const Reference> references,
                           const Split& split) {
  struct Chunk {
    ReferenceBuffer left, right;
    HalfCounts counts, first;
  };
  std::vector<Chunk> chunks((references.size() + kChunk - 1) / kChunk);
  tbb::parallel_for(size_t{0}, chunks.size(), [&](size_t c) {
    const size_t first = c * kChunk, count = std::min(kChunk, references.size() - first);
    Chunk& chunk = chunks[c];
    chunk.left = ReferenceBuffer(count + 1);
    chunk.right = ReferenceBuffer(count + 1);
    ReferenceBuffer cut(count + 1);
    const Lists begin = {chunk.left.data(), chunk.right.data(), cut.data()};
    Lists end = deal(references.data() + first, count, split, begin);
    cut_all(geometries, {begin.cut, end.cut}, split, end.left, end.right);
    chunk.counts = {static_cast<size_t>(end.left - begin.left), static_cast<size_t>(end.right - begin.right)};
  });
  Halves out;
  for (Chunk& chunk : chunks) {
    chunk.first = out.counts;
    out.counts.left += chunk.counts.left;
    out.counts.right += chunk.counts.right;
  }
  out.left = ReferenceBuffer(out.counts.left);
  out.right = ReferenceBuffer(out.counts.right);
  tbb::parallel_for(size_t{0}, chunks.size(), [&](size_t c) {
    Chunk& chunk = chunks[c];
    std::copy_n(chunk.left.data(), chunk.counts.left, out.left.data() + chunk.first.left);
    std::copy_n(chunk.right.data(), chunk.counts.right, out.right.data() + chunk.first.right);
    chunk = {};
  });
  return out;
}

} // namespace kindling::accel::kd
