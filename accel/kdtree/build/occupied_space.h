// The bounds of many references, four at a time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/build/reference.h"
#include "accel/vectors.h"

#include <ImathBox.h>

#include <array>
#include <limits>
#include <span>

namespace kindling::accel::kd {

// The box around all references of a node, which may be smaller than its cell. Lanes are those of a
// Reference: the lower bounds of min_bound and the upper bounds of max_bound are valid.
struct OccupiedSpace {
  Float8 min_bound = splat(std::numeric_limits<float>::max());
  Float8 max_bound = splat(std::numeric_limits<float>::lowest());

  void extend(const OccupiedSpace& other) {
    min_bound = vector_min(other.min_bound, min_bound);
    max_bound = vector_max(other.max_bound, max_bound);
  }
  // Four minima and maxima are independent, so that none waits for the one before.
  void extend(std::span<const Reference> references) {
    std::array<OccupiedSpace, 4> parts;
    const size_t whole = references.size() / 4 * 4;
    const auto add = [&](OccupiedSpace& part, size_t i) {
      const auto bounds = load_vector<Float8>(&references[i]);
      part.min_bound = vector_min(bounds, part.min_bound);
      part.max_bound = vector_max(bounds, part.max_bound);
    };
    for (size_t i = 0; i < whole; i += 4)
      for (size_t k = 0; k < 4; ++k) add(parts[k], i + k);
    for (size_t i = whole; i < references.size(); ++i) add(parts[0], i);
    for (const OccupiedSpace& part : parts) extend(part);
  }
  [[nodiscard]] Imath::Box3f box() const {
    return {{min_bound[0], min_bound[1], min_bound[2]}, {max_bound[4], max_bound[5], max_bound[6]}};
  }
};

} // namespace kindling::accel::kd
