// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/partition.h"

#include "accel/kdtree/clipping.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>

namespace kindling::accel::kd {
namespace {

constexpr size_t kChunk = 32768; // fixed, so that results do not depend on the number of threads

// Both parts if the triangle really lies on both sides. If rounding leaves none, both keep the unclipped bounds.
void clip_both(std::span<const Geometry> geometries, const Reference& reference, const Split& split, Halves& out) {
  const Geometry& geometry = geometries[reference.geometry];
  const std::array<Imath::V3f, 3> triangle = {geometry.vertex(reference.triangle, 0),
                                              geometry.vertex(reference.triangle, 1),
                                              geometry.vertex(reference.triangle, 2)};
  Reference left = reference, right = reference;
  left.max[split.axis] = split.position;
  right.min[split.axis] = split.position;
  const Imath::V3f left_max = left.max, right_min = right.min;
  const bool in_left = clip_bounds(triangle, reference.min, left_max, left.min, left.max);
  const bool in_right = clip_bounds(triangle, right_min, reference.max, right.min, right.max);
  if (!in_left && !in_right) {
    left = right = reference;
    left.max[split.axis] = right.min[split.axis] = split.position;
  }
  if (in_left || !in_right) out.left.push_back(left);
  if (in_right || !in_left) out.right.push_back(right);
}

void partition_chunk(std::span<const Geometry> geometries, std::span<const Reference> references, const Split& split,
                     Halves& out) {
  size_t left = 0, right = 0;
  for (const Reference& reference : references) {
    left += reference.min[split.axis] <= split.position ? 1 : 0;
    right += reference.max[split.axis] >= split.position ? 1 : 0;
  }
  out.left.reserve(left);
  out.right.reserve(right);
  for (const Reference& reference : references) {
    const float low = reference.min[split.axis], high = reference.max[split.axis];
    if (low == split.position && high == split.position) {
      (split.planar_left ? out.left : out.right).push_back(reference);
    } else if (high <= split.position) {
      out.left.push_back(reference);
    } else if (low >= split.position) {
      out.right.push_back(reference);
    } else {
      clip_both(geometries, reference, split, out);
    }
  }
}

std::vector<Reference> join(std::vector<Halves>& parts, std::vector<Reference> Halves::*side) {
  std::vector<size_t> offsets(parts.size() + 1, 0);
  for (size_t i = 0; i < parts.size(); ++i) offsets[i + 1] = offsets[i] + (parts[i].*side).size();
  std::vector<Reference> out(offsets.back());
  tbb::parallel_for(size_t{0}, parts.size(), [&](size_t i) {
    std::copy((parts[i].*side).begin(), (parts[i].*side).end(), out.begin() + static_cast<std::ptrdiff_t>(offsets[i]));
    (parts[i].*side) = {};
  });
  return out;
}

} // namespace

Halves partition(std::span<const Geometry> geometries, std::span<const Reference> references, const Split& split) {
  Halves out;
  if (references.size() <= kChunk) {
    partition_chunk(geometries, references, split, out);
    return out;
  }
  std::vector<Halves> parts((references.size() + kChunk - 1) / kChunk);
  tbb::parallel_for(size_t{0}, parts.size(), [&](size_t i) {
    const size_t first = i * kChunk;
    partition_chunk(geometries, references.subspan(first, std::min(kChunk, references.size() - first)), split,
                    parts[i]);
  });
  out.left = join(parts, &Halves::left);
  out.right = join(parts, &Halves::right);
  return out;
}

} // namespace kindling::accel::kd
