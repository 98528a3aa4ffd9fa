// Parallel conversion and compaction of index lists.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/document/triangles.h"

#include "renderer/base/uninitialized_vector.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <atomic>
#include <limits>

namespace kindling::gltf {
namespace {

constexpr size_t kTriangleGrain = 1U << 14;

// Calls f(begin, end) for disjoint ranges that cover [0, count).
template <typename F>
void for_ranges(size_t count, const F& f) {
  tbb::parallel_for(tbb::blocked_range<size_t>(0, count, kTriangleGrain),
                    [&](const tbb::blocked_range<size_t>& range) { f(range.begin(), range.end()); });
}

struct Span {
  uint32_t min = std::numeric_limits<uint32_t>::max(), max = 0;
};

Span span_of(std::span<const uint32_t> indices) {
  return tbb::parallel_reduce(
      tbb::blocked_range<size_t>(0, indices.size(), kTriangleGrain), Span(),
      [&](const tbb::blocked_range<size_t>& range, Span span) {
        for (size_t i = range.begin(); i < range.end(); ++i) {
          span.min = std::min(span.min, indices[i]);
          span.max = std::max(span.max, indices[i]);
        }
        return span;
      },
      [](const Span& a, const Span& b) {
        return Span{std::min(a.min, b.min), std::max(a.max, b.max)};
      });
}

} // namespace

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
  std::vector<uint32_t> list(size);
  for_ranges(size / 3, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      uint32_t* const corners = &list[3 * i];
      corners[0] = indices[mode == kModeFan ? i + 1 : i];
      corners[1] = indices[mode == kModeFan ? i + 2 : i + 1 + i % 2];
      corners[2] = indices[mode == kModeFan ? 0 : i + 2 - i % 2];
    }
  });
  return list;
}

std::optional<size_t> first_out_of_bounds(std::span<const uint32_t> indices, uint32_t vertex_count) {
  if (indices.empty() || span_of(indices).max < vertex_count) return std::nullopt;
  const auto found =
      std::find_if(indices.begin(), indices.end(), [&](uint32_t index) { return index >= vertex_count; });
  return static_cast<size_t>(found - indices.begin());
}

std::vector<uint32_t> compact_vertices(std::vector<uint32_t>& indices, uint32_t vertex_count) {
  if (indices.empty()) return {};
  const Span span = span_of(indices);
  // Allocate the used range only: many small primitives may share one long list.
  UninitializedVector<uint32_t> number(size_t{span.max - span.min} + 1);
  for_ranges(number.size(), [&](size_t begin, size_t end) { std::fill(&number[begin], number.data() + end, 0U); });
  for_ranges(indices.size(), [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const std::atomic_ref<uint32_t> used(number[indices[i] - span.min]);
      if (used.load(std::memory_order_relaxed) == 0) used.store(1, std::memory_order_relaxed);
    }
  });

  // Count the used vertices before each block, then number them.
  const size_t blocks = (number.size() + kTriangleGrain - 1) / kTriangleGrain;
  const auto block_end = [&](size_t block) { return std::min((block + 1) * kTriangleGrain, number.size()); };
  std::vector<uint32_t> used_before(blocks + 1, 0);
  tbb::parallel_for(size_t{0}, blocks, [&](size_t block) {
    uint32_t count = 0;
    for (size_t i = block * kTriangleGrain; i < block_end(block); ++i) count += number[i];
    used_before[block + 1] = count;
  });
  for (size_t block = 0; block < blocks; ++block) used_before[block + 1] += used_before[block];
  if (used_before[blocks] == vertex_count) return {};
  std::vector<uint32_t> used(used_before[blocks]);
  tbb::parallel_for(size_t{0}, blocks, [&](size_t block) {
    uint32_t next = used_before[block];
    for (size_t i = block * kTriangleGrain; i < block_end(block); ++i) {
      if (number[i] == 0) continue;
      number[i] = next;
      used[next++] = span.min + static_cast<uint32_t>(i);
    }
  });
  for_ranges(indices.size(), [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) indices[i] = number[indices[i] - span.min];
  });
  return used;
}

} // namespace kindling::gltf
