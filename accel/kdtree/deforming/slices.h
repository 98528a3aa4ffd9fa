// The deforming meshes of a group: a tree for each slice of the shutter.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/build/build.h"
#include "accel/kdtree/deforming/swept.h"
#include "accel/kdtree/node.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <vector>

namespace kindling::accel::kd {

struct DeformingSlice {
  TimeSlice slice;
  Tree tree; // its bounds are those of the slice
};

struct DeformingTrees {
  static constexpr uint32_t kMaxSlices = 8;

  std::vector<DeformingSlice> slices;         // in order of time; empty if nothing can be hit
  std::array<uint8_t, kMaxSlices> slice_of{}; // index into `slices` for each eighth of the shutter
  Imath::Box3f bounds;                        // of the whole shutter
  size_t triangle_count = 0;

  // Returns the slice of a time in [0, 1].
  [[nodiscard]] const DeformingSlice& slice_at(float time) const {
    assert(!slices.empty() && time >= 0.0f && time <= 1.0f);
    const auto part = static_cast<uint32_t>(time * static_cast<float>(kMaxSlices));
    return slices[slice_of[std::min(part, kMaxSlices - 1)]];
  }
};

// Builds the trees of deforming geometries. A slice is halved while the trees of its halves are
// expected to be cheaper by a fifth or more, as estimated by small trees over a sample of the
// triangles; slices stay whole where neighbors move alike, however fast. At most kMaxSlices slices,
// fewer for large meshes, with 32 references per triangle in all of them. After a cancellation the
// result is incomplete; check the monitor.
[[nodiscard]] DeformingTrees build_deforming(const Config& config, const std::vector<Geometry>& geometries,
                                             BuildMonitor& monitor);

} // namespace kindling::accel::kd
