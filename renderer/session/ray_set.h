// Rays recorded for races of accelerators: what is asked, and how the rays were grouped. Plain data.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/base/math.h"

#include <cstdint>
#include <string>
#include <vector>

namespace kindling {

enum class RayQuery : uint32_t { nearest = 0, any_hit = 1 };

// Rays of one kind, in the order in which a renderer traces them.
struct RaySet {
  std::string name; // at most 31 of a-z, 0-9 and '-'
  RayQuery query = RayQuery::nearest;
  uint32_t coherent_group =
      0; // this many rays in a row start close together and are almost parallel; 0: no such groups
  std::vector<accel::Ray> rays;
};

// All sets of one scene.
struct RayRecording {
  uint64_t geometry_hash = 0; // hash_geometry() of what the rays were traced through
  V2i size_px{0, 0};          // of the image that they were recorded for
  std::vector<RaySet> sets;
};

// A hash of all that an accelerator is built from: vertices, indices, placement, and which meshes are opaque.
[[nodiscard]] uint64_t hash_geometry(const accel::BuildInput& input);

} // namespace kindling
