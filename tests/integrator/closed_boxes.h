// Closed boxes that light must not enter, in memory.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/integrator/motion_scenes.h"

#include <array>

namespace kindling::test {

// Six walls from -1 to 1 with vertices of their own, moved by `turn`: those of neighbors are equal
// to the bit. Lines are at `grid` along both edges of a wall.
inline Primitive box_walls(const M44f& turn, const std::vector<float>& grid = {-1.0f, 1.0f}, int material = 0) {
  Primitive primitive;
  primitive.material = material;
  const auto row = static_cast<uint32_t>(grid.size());
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      const auto first = static_cast<uint32_t>(primitive.positions.size());
      for (const float b : grid)
        for (const float a : grid) {
          V3f p;
          p[axis] = side, p[(axis + 1) % 3] = a, p[(axis + 2) % 3] = b;
          primitive.positions.push_back(transform_point(turn, p));
        }
      for (uint32_t j = 0; j + 1 < row; ++j)
        for (uint32_t i = 0; i + 1 < row; ++i) {
          const uint32_t k = first + j * row + i;
          for (const uint32_t index : {k, k + 1, k + row + 1, k, k + row + 1, k + row})
            primitive.indices.push_back(index);
        }
    }
  return primitive;
}

// The inside is the same box, but walls stand on the inside of floor and ceiling, and on each
// other, at exact coordinates if those of `center` are whole numbers.
inline std::vector<Primitive> t_junctions(const V3f& center) {
  return {quad(center + V3f(-2, -1, -2), V3f(0, 0, 4), V3f(4, 0, 0), 0),
          quad(center + V3f(-2, 1, -2), V3f(4, 0, 0), V3f(0, 0, 4), 0),
          quad(center + V3f(-1, -1, -1.5f), V3f(0, 2, 0), V3f(0, 0, 3), 0),
          quad(center + V3f(1, -1, -1.5f), V3f(0, 2, 0), V3f(0, 0, 3), 0),
          quad(center + V3f(-1, -1, -1), V3f(2, 0, 0), V3f(0, 2, 0), 0),
          quad(center + V3f(-1, -1, 1), V3f(2, 0, 0), V3f(0, 2, 0), 0)};
}

inline M44f moved_to(const V3f& center) { return M44f().setTranslation(center); }

// A rotation by which no edge is parallel to an axis, then a translation.
inline M44f turned_to(const V3f& center) {
  M44f m = Quatf(0.7852f, V3f(0.2f, 0.5f, -0.3f)).normalized().toMatrix44();
  m[3][0] = center.x, m[3][1] = center.y, m[3][2] = center.z;
  return m;
}

// Centers at this distance; whole numbers from 25 on.
inline V3f center_at(float distance) { return V3f(0.6f, 0.48f, 0.64f) * distance; }

} // namespace kindling::test
