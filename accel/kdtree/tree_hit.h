// Hits within a tree, and the order of hits at equal distance.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/ray.h"

#include <cstdint>

namespace kindling::accel::kd {

// Order of hits at equal distance: the smallest ids come first.
inline bool comes_before(const Hit& a, const Hit& b) {
  if (a.instance != b.instance) return a.instance < b.instance;
  return a.mesh != b.mesh ? a.mesh < b.mesh : a.triangle < b.triangle;
}

// The best hit so far in one tree.
struct TreeHit {
  float t = 0.0f, u = 0.0f, v = 0.0f;
  uint32_t primitive = kNoId;

  [[nodiscard]] bool is_hit() const { return primitive != kNoId; }
};

} // namespace kindling::accel::kd
