// Light groups as plain arrays, for the stages of path tracing.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/ray.h"
#include "renderer/light/light_sample.h"
#include "renderer/light/light_set_view.h"
#include "renderer/world/surface_nodes.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace kindling {

// The group of everything that emits. All are below `count`.
struct LightGroupsView {
  static constexpr uint8_t kByMaterial = 0xff;

  uint32_t count = 0;                   // 0: light is not split by group
  uint8_t environment = 0;              // and the background in its place
  std::span<const uint8_t> of_emitter;  // by LightSample::emitter
  std::span<const uint8_t> of_node;     // of its surfaces, or kByMaterial; empty: all by material
  std::span<const uint8_t> of_material; // by SurfacePoint::material
  SurfaceNodes nodes{};

  [[nodiscard]] uint8_t of(const LightSample& sample) const {
    if (count == 0) return 0;
    return sample.kind == LightKind::environment ? environment : of_emitter[sample.emitter];
  }
  [[nodiscard]] uint8_t of_surface(int node, uint32_t material) const {
    const bool known = node >= 0 && static_cast<size_t>(node) < of_node.size();
    return known && of_node[static_cast<size_t>(node)] != kByMaterial ? of_node[static_cast<size_t>(node)]
                                                                      : of_material[material];
  }
  [[nodiscard]] uint8_t of_surface(const accel::Hit& hit, uint32_t material) const {
    if (count == 0) return 0;
    return of_surface(of_node.empty() ? -1 : nodes.node_of(hit.mesh, hit.instance), material);
  }
  // `number`: of a lamp, sun or other light that is no surface.
  [[nodiscard]] uint8_t of_punctual(const LightSetView& lights, uint32_t number) const {
    return count == 0 ? uint8_t{0} : of_emitter[lights.triangles.size() + number];
  }
};

} // namespace kindling
