// Recorded rays as plain data: queries, groups, and the hash of their geometry.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/base/math.h"

#include <cstdint>
#include <string>
#include <vector>

namespace kindling {

enum class RayQuery : uint32_t { nearest = 0, any_hit = 1 };

// Rays of one kind in the order in which a render traces them.
struct RaySet {
  std::string name; // at most 31 of a-z, 0-9 and '-'
  RayQuery query = RayQuery::nearest;
  uint32_t coherent_group =
      0; // number of consecutive rays with close origins and nearly equal directions; 0: no groups
  std::vector<accel::Ray> rays;
};

// All ray sets of one scene.
struct RayRecording {
  uint64_t geometry_hash = 0; // hash_geometry() of the traced geometry; 0: rays from elsewhere, for any
  V2i size_px{0, 0};          // of the recorded image; 0: of none
  std::vector<RaySet> sets;
};

// Returns a hash of everything that an accelerator is built from: vertices, indices, placement,
// opacity of meshes.
[[nodiscard]] uint64_t hash_geometry(const accel::BuildInput& input);

} // namespace kindling
