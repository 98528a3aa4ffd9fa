// Learned directions of the light inside of scattering media, by region of space.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/owned_arrays.h"
#include "renderer/guiding/octahedron.h"
#include "renderer/guiding/region_node.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <span>

namespace kindling {

// Light that was scattered in a medium, on its way from a lamp.
struct VolumeRecord {
  V3f position{0.0f};
  V3f direction{0.0f}; // unit, to where it came from
  float weight = 0.0f; // radiant power, in any unit; above 0
};

// Directions that are brighter than others, as a point in a medium sees them: lamps and bright
// places of the sky behind the boundary. A binary tree over space; each region has a quadtree over
// the directions, which are points of a square (octahedron.h; quadtrees: Mueller et al. 2017,
// "Practical Path Guiding for Efficient Light-Transport Simulation"). Immutable, thread-safe.
struct VolumeGuideView {
  struct Region {
    float share = 0.0f; // of the bright directions in all light there, below 1; 0: there are none
    uint32_t root = 0;  // quarters of all directions; only if share > 0
    V3f mean{0.0f};     // of the bright directions: the more they are spread, the shorter
  };
  // Four quarters of a square, those of lower y first, and of lower x first among these.
  struct Quarters {
    std::array<float, 4> shares;    // of what the square has; their sum is 1
    std::array<uint32_t, 4> inside; // number of the quarter's own quarters; 0: it has the same density everywhere
  };
  static_assert(sizeof(Quarters) == 32);

  // True if no region has bright directions.
  [[nodiscard]] bool empty() const { return quarters.empty(); }
  // Returns the region of a point. The guide must not be empty.
  [[nodiscard]] const Region& find(const V3f& position) const {
    assert(!empty());
    return regions[find_region(nodes, 0, position)];
  }
  // Returns a direction, unit, for random numbers in [0, 1)^2. `root` is that of a region.
  [[nodiscard]] V3f sample(uint32_t root, V2f u) const;
  // Returns the density of a unit direction, per steradian; above 0.
  [[nodiscard]] float pdf(uint32_t root, const V3f& direction) const;

  std::span<const RegionNode> nodes;
  std::span<const Region> regions;
  std::span<const Quarters> quarters; // number 0 is a root, and no quarter's inside
};

class VolumeGuide : public VolumeGuideView {
 public:
  VolumeGuide() = default;
  // Sorts `records`. Deterministic in the records and their order.
  explicit VolumeGuide(std::span<VolumeRecord> records);

  // Returns the number of regions with bright directions.
  [[nodiscard]] size_t bright_region_count() const {
    return static_cast<size_t>(
        std::count_if(regions.begin(), regions.end(), [](const Region& region) { return region.share > 0.0f; }));
  }

 private:
  OwnedArrays arrays_;
};

inline V3f VolumeGuideView::sample(uint32_t root, V2f u) const {
  constexpr float kBelowOne = 1.0f - 0x1p-24f;
  V2f corner{0.0f};
  float size = 1.0f;
  for (uint32_t at = root;;) {
    const Quarters& here = quarters[at];
    size *= 0.5f;
    uint32_t quarter = 0;
    const float left = here.shares[0] + here.shares[2];
    if (u.x < left) {
      u.x /= left;
    } else {
      quarter = 1;
      corner.x += size;
      u.x = (u.x - left) / (1.0f - left);
    }
    const float below = here.shares[quarter] / (here.shares[quarter] + here.shares[quarter + 2]);
    if (u.y < below) {
      u.y /= below;
    } else {
      quarter += 2;
      corner.y += size;
      u.y = (u.y - below) / (1.0f - below);
    }
    u = {std::min(u.x, kBelowOne), std::min(u.y, kBelowOne)};
    at = here.inside[quarter];
    if (at == 0) return direction_of_point(corner + u * size);
  }
}

inline float VolumeGuideView::pdf(uint32_t root, const V3f& direction) const {
  V2f point = point_of_direction(direction);
  float density = 1.0f;
  for (uint32_t at = root;;) {
    const Quarters& here = quarters[at];
    const uint32_t quarter = quarter_of(point);
    density *= 4.0f * here.shares[quarter];
    at = here.inside[quarter];
    if (at == 0) return density / steradians_per_area(direction);
    point = point_in_quarter(point, quarter);
  }
}

} // namespace kindling
