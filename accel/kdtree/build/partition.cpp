// Branch-free partitioning of references: in place, to new lists, and of blocks in parallel.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/build/partition.h"

#include "accel/kdtree/build/bounds_across.h"
#include "accel/kdtree/build/clipping.h"
#include "accel/vectors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstddef>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

namespace kindling::accel::kd {
namespace {

// Ends of the lists that references are dealt to.
struct Lists {
  Reference *left, *right, *cut;
};

// Finds sides by arithmetic, since no branch on them could be predicted.
template <size_t kAxis, bool kPlanarLeft>
class Dealer {
 public:
  explicit Dealer(float position)
      : position_{position, position, position, position, -position, -position, -position, -position} {}

  // Writes each reference to the end of all three lists and advances only its own, so that there
  // are no branches; the next reference overwrites the others. A list may begin where the
  // references do.
  [[nodiscard]] Lists deal(const Reference* references, size_t count, Lists end) const {
    size_t i = 0;
    for (; i + 4 <= count; i += 4) {
      const std::array<Int8, 4> four = {load_vector<Int8>(references + i), load_vector<Int8>(references + i + 1),
                                        load_vector<Int8>(references + i + 2), load_vector<Int8>(references + i + 3)};
      const Sides sides = sides_of(four);
      append(four, sides.left, end.left);
      append(four, sides.right, end.right);
      append(four, ~(sides.left | sides.right) & 15U, end.cut);
    }
    for (; i < count; ++i) {
      const auto lanes = load_vector<Int8>(references + i);
      const Sides sides = sides_of({lanes, lanes, lanes, lanes});
      store_vector(end.left, lanes);
      store_vector(end.right, lanes);
      store_vector(end.cut, lanes);
      end.left += sides.left & 1U;
      end.right += sides.right & 1U;
      end.cut += ~(sides.left | sides.right) & 1U;
    }
    return end;
  }

 private:
  // A bit for each of four references.
  struct Sides {
    uint32_t left, right;
  };
  [[nodiscard]] Sides sides_of(const std::array<Int8, 4>& four) const {
    const auto floats = [](Int8 lanes) { return std::bit_cast<Float8>(lanes); };
    constexpr int32_t kSign = std::numeric_limits<int32_t>::min();
    constexpr Int8 kNegateEnds = {0, 0, 0, 0, kSign, kSign, kSign, kSign};
    const Float8 bounds = bounds_across<kAxis>(floats(four[0]), floats(four[1]), floats(four[2]), floats(four[3]));
    const Float8 starts_and_ends = std::bit_cast<Float8>(std::bit_cast<Int8>(bounds) ^ kNegateEnds);
    const uint32_t beside = sign_bits(starts_and_ends >= position_), starts_above = beside & 15U,
                   ends_below = beside >> 4;
    return {kPlanarLeft ? ends_below : ends_below & ~starts_above,
            kPlanarLeft ? starts_above & ~ends_below : starts_above};
  }

  // For each set of four references, how far the end of a list is after each of them, in bytes.
  static constexpr std::array<std::array<uint8_t, 4>, 16> kAdvance = [] {
    std::array<std::array<uint8_t, 4>, 16> advance{};
    for (uint32_t set = 0; set < 16; ++set)
      for (uint32_t i = 0; i < 4; ++i)
        advance[set][i] = static_cast<uint8_t>(std::popcount(set & ((2U << i) - 1)) * sizeof(Reference));
    return advance;
  }();
  static void append(const std::array<Int8, 4>& four, uint32_t set, Reference*& end) {
    const std::array<uint8_t, 4>& advance = kAdvance[set];
    auto* const first = reinterpret_cast<std::byte*>(end);
    store_vector(first, four[0]);
    for (size_t i = 1; i < 4; ++i) store_vector(first + advance[i - 1], four[i]);
    end = reinterpret_cast<Reference*>(first + advance[3]);
  }

  Float8 position_; // negated for ends
};

Lists deal(const Reference* references, size_t count, const Split& split, const Lists& lists) {
  const auto across = [&]<size_t kAxis>(std::integral_constant<size_t, kAxis>) {
    return split.planar_left ? Dealer<kAxis, true>(split.position).deal(references, count, lists)
                             : Dealer<kAxis, false>(split.position).deal(references, count, lists);
  };
  switch (split.axis) {
  case 0: return across(std::integral_constant<size_t, 0>());
  case 1: return across(std::integral_constant<size_t, 1>());
  default: return across(std::integral_constant<size_t, 2>());
  }
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

namespace {

// The blocks first <= i < last.
struct Group {
  size_t first, last, count;
};

// Groups depend on the blocks alone, not on threads.
std::vector<Group> groups_of(const ReferenceBlocks& references) {
  constexpr size_t kGroupReferences = 16384;
  std::vector<Group> groups;
  const std::span<const std::span<Reference>> blocks = references.blocks();
  for (size_t i = 0; i < blocks.size(); ++i) {
    if (groups.empty() || groups.back().count + blocks[i].size() > kGroupReferences) groups.push_back({i, i, 0});
    groups.back().last = i + 1;
    groups.back().count += blocks[i].size();
  }
  return groups;
}

BlockHalves partition_group(const BuildMeshes& meshes, ReferenceBlocks& references, const Group& group,
                            const Split& split, BlockPool& pool) {
  BlockHalves out{ReferenceBlocks(pool), ReferenceBlocks(pool)};
  ReferenceBlocks cut(pool);
  // As many at a time as fit into all lists.
  for (size_t i = group.first; i < group.last; ++i) {
    for (std::span<const Reference> left_over = references.blocks()[i]; !left_over.empty();) {
      const size_t fits = std::min({left_over.size(), out.left.room(), out.right.room(), cut.room()});
      const Lists end = deal(left_over.data(), fits, split, {out.left.end(), out.right.end(), cut.end()});
      out.left.advance_to(end.left);
      out.right.advance_to(end.right);
      cut.advance_to(end.cut);
      left_over = left_over.subspan(fits);
    }
    references.release(i);
  }
  for (std::span<const Reference> left_over : cut.blocks())
    while (!left_over.empty()) {
      const size_t fits = std::min({left_over.size(), out.left.room(), out.right.room()});
      Reference *left = out.left.end(), *right = out.right.end();
      cut_all(meshes, left_over.first(fits), split, left, right);
      out.left.advance_to(left);
      out.right.advance_to(right);
      left_over = left_over.subspan(fits);
    }
  return out;
}

} // namespace

BlockHalves partition(const BuildMeshes& meshes, ReferenceBlocks references, const Split& split, BlockPool& pool) {
  const std::vector<Group> groups = groups_of(references);
  std::vector<std::optional<BlockHalves>> parts(groups.size());
  tbb::parallel_for(size_t{0}, groups.size(),
                    [&](size_t g) { parts[g].emplace(partition_group(meshes, references, groups[g], split, pool)); });
  BlockHalves out{ReferenceBlocks(pool), ReferenceBlocks(pool)};
  for (std::optional<BlockHalves>& part : parts) {
    out.left.append(std::move(part->left));
    out.right.append(std::move(part->right));
  }
  return out;
}

} // namespace kindling::accel::kd
