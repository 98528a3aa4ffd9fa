// Branch-free partitioning of references, serial in place and parallel in chunks.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/partition.h"

#include "accel/kdtree/clipping.h"
#include "accel/vectors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cassert>

namespace kindling::accel::kd {
namespace {

constexpr size_t kChunkReferences = 16384; // fixed, so that results do not depend on the number of threads

// The side of a reference: exactly one member is true.
struct Sides {
  bool left, right, cut;
};
Sides side_of(const Reference& reference, const Split& split) {
  const float* bounds = &reference.min.x;
  const auto axis = static_cast<size_t>(split.axis);
  const bool ends_below = bounds[axis + 4] <= split.position, starts_above = bounds[axis] >= split.position;
  const bool left = ends_below && (!starts_above || split.planar_left);
  return {left, starts_above && !left, !ends_below && !starts_above};
}

// Writes each reference to the end of all three lists and advances only its own, so that there are
// no branches; the next reference overwrites the others.
struct Lists {
  Reference *left, *right, *cut;
};
Lists deal(const Reference* references, size_t count, const Split& split, Lists lists) {
  for (size_t i = 0; i < count; ++i) {
    const auto lanes = load_vector<Int8>(references + i);
    const Sides side = side_of(references[i], split);
    store_vector(lists.left, lanes);
    store_vector(lists.right, lanes);
    store_vector(lists.cut, lanes);
    lists.left += side.left ? 1 : 0;
    lists.right += side.right ? 1 : 0;
    lists.cut += side.cut ? 1 : 0;
  }
  return lists;
}

void cut_all(const BuildMeshes& meshes, std::span<const Reference> references, const Split& split, Reference*& left,
             Reference*& right) {
  // Triangles are scattered in memory: prefetches indices several references ahead, then vertices.
  constexpr size_t kIndicesAhead = 8, kVerticesAhead = 4;
  const auto indices_of = [&](const Reference& r) {
    return meshes.geometries[r.geometry].mesh.indices.data() + 3 * static_cast<size_t>(r.triangle);
  };
  for (size_t i = 0; i < references.size(); ++i) {
    if (i + kIndicesAhead < references.size()) __builtin_prefetch(indices_of(references[i + kIndicesAhead]));
    if (i + kVerticesAhead < references.size()) {
      const Reference& ahead = references[i + kVerticesAhead];
      const uint32_t* indices = indices_of(ahead);
      const Imath::V3f* positions = meshes.geometries[ahead.geometry].mesh.positions.data();
      for (size_t corner = 0; corner < 3; ++corner) __builtin_prefetch(positions + indices[corner]);
    }
    const Reference& reference = references[i];
    const SplitReference parts = split_reference(meshes, reference, split.axis, split.position);
    if (parts.in_left) copy_references(&parts.left, 1, left++);
    if (parts.in_right) copy_references(&parts.right, 1, right++);
  }
}

} // namespace

void ReferenceBuffer::reserve(size_t size, size_t keep) {
  assert(keep <= capacity_);
  if (size <= capacity_) return;
  size = std::max(size, capacity_ + capacity_ / 2);
  auto items = std::make_unique_for_overwrite<Reference[]>(size);
  copy_references(items_.get(), keep, items.get());
  items_ = std::move(items);
  capacity_ = size;
}

HalfCounts partition_in_place(const BuildMeshes& meshes, Reference* references, size_t count, const Split& split,
                              bool left_in_place, Reference* elsewhere, ReferenceBuffer& scratch) {
  scratch.reserve(count + 1, 0);
  const Lists first = {left_in_place ? references : elsewhere, left_in_place ? elsewhere : references, scratch.data()};
  Lists end = deal(references, count, split, first);
  cut_all(meshes, {first.cut, end.cut}, split, end.left, end.right);
  return {static_cast<size_t>(end.left - first.left), static_cast<size_t>(end.right - first.right)};
}

Halves partition_in_chunks(const BuildMeshes& meshes, std::span<const Reference> references, const Split& split) {
  struct Chunk {
    HalfCounts counts, first;
    std::vector<Reference> left_parts, right_parts; // parts of split references
  };
  std::vector<Chunk> chunks((references.size() + kChunkReferences - 1) / kChunkReferences);
  const auto chunk_of = [&](size_t c) {
    return references.subspan(c * kChunkReferences,
                              std::min(kChunkReferences, references.size() - c * kChunkReferences));
  };

  // Counts what each chunk contributes to each child. Few of the many references here are split.
  tbb::parallel_for(size_t{0}, chunks.size(), [&](size_t c) {
    Chunk& chunk = chunks[c];
    std::vector<Reference> cut;
    for (const Reference& reference : chunk_of(c)) {
      const Sides side = side_of(reference, split);
      chunk.counts.left += side.left ? 1 : 0;
      chunk.counts.right += side.right ? 1 : 0;
      if (side.cut) cut.push_back(reference);
    }
    chunk.left_parts.resize(cut.size());
    chunk.right_parts.resize(cut.size());
    Reference *left_end = chunk.left_parts.data(), *right_end = chunk.right_parts.data();
    cut_all(meshes, cut, split, left_end, right_end);
    chunk.left_parts.resize(static_cast<size_t>(left_end - chunk.left_parts.data()));
    chunk.right_parts.resize(static_cast<size_t>(right_end - chunk.right_parts.data()));
    chunk.counts.left += chunk.left_parts.size();
    chunk.counts.right += chunk.right_parts.size();
  });
  Halves out;
  for (Chunk& chunk : chunks) {
    chunk.first = out.counts;
    out.counts.left += chunk.counts.left;
    out.counts.right += chunk.counts.right;
  }
  out.left = ReferenceBuffer(out.counts.left);
  out.right = ReferenceBuffer(out.counts.right);

  // Uses small lists in the cache, because deal() writes past the end of its lists, where other
  // chunks' references are.
  constexpr size_t kBlock = 256;
  tbb::parallel_for(size_t{0}, chunks.size(), [&](size_t c) {
    const Chunk& chunk = chunks[c];
    std::array<Reference, kBlock + 1> left, right, cut;
    Reference *left_end = out.left.data() + chunk.first.left, *right_end = out.right.data() + chunk.first.right;
    const auto append = [](const Reference* from, size_t count, Reference*& end) {
      copy_references(from, count, end);
      end += count;
    };
    const std::span<const Reference> own = chunk_of(c);
    for (size_t first = 0; first < own.size(); first += kBlock) {
      const Lists end = deal(own.data() + first, std::min(kBlock, own.size() - first), split,
                             {left.data(), right.data(), cut.data()});
      append(left.data(), static_cast<size_t>(end.left - left.data()), left_end);
      append(right.data(), static_cast<size_t>(end.right - right.data()), right_end);
    }
    append(chunk.left_parts.data(), chunk.left_parts.size(), left_end);
    append(chunk.right_parts.data(), chunk.right_parts.size(), right_end);
  });
  return out;
}

} // namespace kindling::accel::kd
