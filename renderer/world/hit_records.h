// Vertex records of one hit, and texture coordinates interpolated from them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/world/geometry.h"
#include "renderer/world/shading_material.h"

#include <array>
#include <cassert>
#include <cmath>

namespace kindling {

// Data shared by all lookups of one hit.
struct HitRecords {
  const GeometryView& geometry;
  std::array<const float*, 3> records;
  V3f barycentric;
  const accel::Hit* hit;

  HitRecords(const GeometryView& g, const accel::Hit& h)
      : geometry(g), barycentric(1.0f - h.u - h.v, h.u, h.v), hit(&h) {
    assert(size_t{h.triangle} * 3 < g.indices.size());
    const uint32_t* index = g.indices.data() + size_t{h.triangle} * 3;
    records = {g.record(index[0]), g.record(index[1]), g.record(index[2])};
  }
  [[nodiscard]] V2f texcoord(uint8_t set) const {
    const uint8_t offset = geometry.texcoord_offset[set];
    return offset == GeometryView::kAbsent ? V2f(0.0f) : geometry.interpolate2(records, offset, barycentric);
  }
  // Returns twice the area of the triangle in the coordinates of a set.
  [[nodiscard]] float texcoord_area(uint8_t set) const {
    const uint8_t offset = geometry.texcoord_offset[set];
    if (offset == GeometryView::kAbsent) return 0.0f;
    const float *a = records[0] + offset, *b = records[1] + offset, *c = records[2] + offset;
    return std::abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
  }
  [[nodiscard]] V2f texcoord(const TextureBinding& binding) const { return binding.apply(texcoord(binding.texcoord)); }
};

} // namespace kindling
