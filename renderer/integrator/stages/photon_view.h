// Photons on surfaces, and those near a point, as all devices read them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace kindling {

// Light that has arrived at a surface over one or more casters (light_path_view.h).
struct Photon {
  static constexpr uint32_t kNoMedium = 0xffffffffU;

  V3f position; // of its surface at rest (rest_surface.h)
  V3f to_light; // unit, where it came from
  V3f normal;   // geometric, unit, on the side of to_light; of the surface at rest
  // Over the cosine, the number of light paths of the map, and the square of the index of
  // refraction there: paths carry radiance over that square, which refraction does not change.
  // Times the area of the surface at rest over that at the photon's time.
  Rgb power;
  float density = 0.0f;     // EmittedRay::density, for the weight
  float distance_m = 0.0f;  // to the surface that it came from, where that is at its time
  float time = 0.0f;        // of the shutter, in [0, 1]
  uint32_t medium = 0;      // material of the medium around it, or kNoMedium
  uint8_t diffuse = 0;      // bounces on its way by kind, without the one nearest to the light
  uint8_t glossy = 0;       //
  uint8_t transmission = 0; //
  uint8_t group = 0;        // LightGroups: of its light; 0 if there are none
};

// The arrays of a PhotonMap (photons/photon_map.h). Immutable and thread-safe.
struct PhotonMapView {
  // The part of a photon that a search reads.
  struct Node {
    V3f position;
    uint32_t axis; // that its range is divided along
  };
  struct Range {
    uint32_t begin, end;
  };
  static constexpr uint32_t kLeaf = 8;    // ranges of fewer are searched one by one
  static constexpr size_t kMaxDepth = 32; // of ranges, which are halved

  // Calls visit(photon) for each photon whose distance to the point is less than the root of
  // `radius2`, always in the same order.
  template <typename Visit>
  void for_each_near(const V3f& point, float radius2, const Visit& visit) const;

  std::span<const Node> nodes;     // in the order of the tree
  std::span<const Photon> photons; // parallel to nodes
};

template <typename Visit>
void PhotonMapView::for_each_near(const V3f& point, float radius2, const Visit& visit) const {
  const auto meet = [&](uint32_t i) {
    if ((nodes[i].position - point).length2() < radius2) visit(photons[i]);
  };
  std::array<Range, kMaxDepth> waiting;
  size_t count = 0;
  Range range{0, static_cast<uint32_t>(nodes.size())};
  for (;;) {
    while (range.end - range.begin >= kLeaf) {
      const uint32_t middle = range.begin + (range.end - range.begin) / 2;
      const Node& node = nodes[middle];
      const float beyond = point[static_cast<int>(node.axis)] - node.position[static_cast<int>(node.axis)];
      const bool crosses = beyond * beyond < radius2;
      if (crosses) meet(middle);
      const Range below{range.begin, middle}, above{middle + 1, range.end};
      range = beyond < 0.0f ? below : above;
      if (crosses) waiting[count++] = beyond < 0.0f ? above : below;
    }
    for (uint32_t i = range.begin; i < range.end; ++i) meet(i);
    if (count == 0) return;
    range = waiting[--count];
  }
}

} // namespace kindling
