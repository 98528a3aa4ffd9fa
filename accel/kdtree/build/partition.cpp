// Branch-free partitioning of references, serial in place and parallel in chunks.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/build/partition.h"

#include "accel/kdtree/build/clipping.h"
#include "accel/vectors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cassert>

namespace kindling::accel::kd {
namespace {

constexpr size_t kChunkReferences = 16384; // fixed, so that results do not depend on the number of threads

// The side of a reference: one member is 1, the others are 0.
struct Sides {
  size_t left, right, cut;
};
// Finds sides by arithmetic, since no branch on them could be predicted.
template <bool kPlanarLeft>
class SideFinder {
 public:
  explicit SideFinder(const Split& split) : axis_(static_cast<size_t>(split.axis)), position_(split.position) {}

  [[nodiscard]] Sides operator()(const Reference& reference) const {
    const float* bounds = &reference.min.x;
    const size_t ends_below = bounds[axis_ + 4] <= position_ ? 1 : 0, starts_above = bounds[axis_] >= position_ ? 1 : 0;
    const size_t left = kPlanarLeft ? ends_below : ends_below & ~starts_above,
                 right = kPlanarLeft ? starts_above & ~ends_below : starts_above;
    return {left, right, 1 - left - right};
  }

 private:
  size_t axis_;
  float position_;
};
// Calls f(side finder) for a split.
template <class F>
auto with_sides(const Split& split, const F& f) {
  return split.planar_left ? f(SideFinder<true>(split)) : f(SideFinder<false>(split));
}

// Writes each reference to the end of all three lists and advances only its own, so that there are
// no branches; the next reference overwrites the others.
struct Lists {
  Reference *left, *right, *cut;
};
Lists deal(const Reference* references, size_t count, const Split& split, Lists lists) {
  return with_sides(split, [=](const auto side_of) {
    Lists end = lists;
    for (size_t i = 0; i < count; ++i) {
      const auto lanes = load_vector<Int8>(references + i);
      const Sides side = side_of(references[i]);
      store_vector(end.left, lanes);
      store_vector(end.right, lanes);
      store_vector(end.cut, lanes);
      end.left += side.left;
      end.right += side.right;
      end.cut += side.cut;
    }
    return end;
  });
}

void copy_reference(const Reference& from, Reference* to) { store_vector(to, load_vector<Int8>(&from)); }

// Each list needs room for all references.
void cut_all(const BuildMeshes& meshes, std::span<const Reference> references, const Split& split, Reference*& left,
             Reference*& right) {
  // Triangles are scattered in memory: prefetches indices several references ahead, then vertices.
  constexpr size_t kIndicesAhead = 12, kVerticesAhead = 6;
  const auto indices_of = [&](const Reference& r) {
    return meshes.geometries[r.geometry].mesh.indices.data() + 3 * static_cast<size_t>(r.triangle);
  };
  const auto prefetch_indices = [&](size_t i) {
    if (i < references.size()) __builtin_prefetch(indices_of(references[i]));
  };
  const auto prefetch_vertices = [&](size_t i) {
    if (i >= references.size()) return;
    const uint32_t* indices = indices_of(references[i]);
    const Imath::V3f* positions = meshes.geometries[references[i].geometry].mesh.positions.data();
    for (size_t corner = 0; corner < 3; ++corner) __builtin_prefetch(positions + indices[corner]);
  };
  // Parts are written in any case, and the lists advance if they are valid.
  const auto append = [&](const SplitReference& parts) {
    copy_reference(parts.left, left);
    copy_reference(parts.right, right);
    left += parts.in_left ? 1 : 0;
    right += parts.in_right ? 1 : 0;
  };
  for (size_t i = 0; i < std::min(kIndicesAhead, references.size()); ++i) prefetch_indices(i);
  for (size_t i = 0; i < std::min(kVerticesAhead, references.size()); ++i) prefetch_vertices(i);
  SplitReference a, b;
  for (size_t i = 0; i < references.size(); i += 2) {
    for (size_t k = i; k < i + 2; ++k) {
      prefetch_indices(k + kIndicesAhead);
      prefetch_vertices(k + kVerticesAhead);
    }
    const bool two = i + 1 < references.size();
    split_two(meshes, references[i], references[two ? i + 1 : i], split.axis, split.position, a, b);
    append(a);
    if (two) append(b);
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
    chunk.counts = with_sides(split, [&](const auto side_of) {
      HalfCounts counts;
      for (const Reference& reference : chunk_of(c)) {
        const Sides side = side_of(reference);
        counts.left += side.left;
        counts.right += side.right;
        if (side.cut != 0) cut.push_back(reference);
      }
      return counts;
    });
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

  // As deal(), but a full list leaves what is after it, which is another chunk's.
  tbb::parallel_for(size_t{0}, chunks.size(), [&](size_t c) {
    const Chunk& chunk = chunks[c];
    Reference spare;
    Reference* left = out.left.data() + chunk.first.left;
    Reference* right = out.right.data() + chunk.first.right;
    Reference* const left_end = left + (chunk.counts.left - chunk.left_parts.size());
    Reference* const right_end = right + (chunk.counts.right - chunk.right_parts.size());
    with_sides(split, [&](const auto side_of) {
      for (const Reference& reference : chunk_of(c)) {
        const auto lanes = load_vector<Int8>(&reference);
        const Sides side = side_of(reference);
        store_vector(left < left_end ? left : &spare, lanes);
        store_vector(right < right_end ? right : &spare, lanes);
        left += side.left;
        right += side.right;
      }
    });
    assert(left == left_end && right == right_end);
    copy_references(chunk.left_parts.data(), chunk.left_parts.size(), left_end);
    copy_references(chunk.right_parts.data(), chunk.right_parts.size(), right_end);
  });
  return out;
}

} // namespace kindling::accel::kd
