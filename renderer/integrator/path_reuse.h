// A batch's records of paths that are shared between pixels, and the links between them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/film.h"
#include "renderer/integrator/lanes/reuse_lanes.h"
#include "renderer/integrator/stages/reuse_paths.h"
#include "renderer/sampling/sample_range.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

// One thread's memory for it. Sized once.
struct PathReuse {
  PathReuse(size_t batch_size, uint32_t group_size);

  // Clears the records of the first `count` paths.
  void start(size_t count);
  [[nodiscard]] ReuseView view() { return {paths.data(), links.data(), group_size}; }

  uint32_t group_size;            // IntegratorSettings::path_reuse
  std::vector<PixelRect> blocks;  // of the batch: whole ones
  std::vector<ReusedPath> paths;  // by slot
  std::vector<ReuseGroup> groups; // by slot
  std::vector<ReuseLink> links;   // by slot and place, where light is split
  // Each group once, with all places, and by these numbers its links and their rays.
  std::vector<ReuseGroup> whole_groups;
  std::vector<GroupLinks> group_links;
  std::vector<LinkRays> group_rays;
  std::vector<uint32_t> places; // by slot: number of the group * kMaxPathReuse + lane
  std::vector<accel::Ray> rays;
  // The link that a ray is for: its number in `links`, or else (number of the group *
  // kMaxPathReuse + place) * kMaxPathReuse + lane.
  std::vector<uint32_t> ray_links;
  std::vector<uint8_t> occluded;
};

// Finds the groups of a batch: `samples` of every pixel of these whole blocks, one block after the
// other, sample by sample, pixels row by row. All places are set, also those beyond the size of
// groups.
void find_groups(std::span<const PixelRect> blocks, const SampleRange& samples, std::span<ReuseGroup> groups);

} // namespace kindling
