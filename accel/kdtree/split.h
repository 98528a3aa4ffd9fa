// Where to cut a node: the surface area heuristic and the two searches for the plane that it likes best.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/config.h"
#include "accel/kdtree/reference.h"

#include <ImathBox.h>

#include <optional>
#include <span>
#include <vector>

namespace kindling::accel::kd {

struct Split {
  double cost = 0.0;
  float position = 0.0f; // strictly inside the box
  int axis = 0;
  bool planar_left = false; // side that takes triangles lying in the plane
};

// Half the surface area of a box, in double: the extents of the largest scenes would overflow in float.
[[nodiscard]] inline double half_area(const Imath::Box3f& box) {
  const Imath::V3d d = Imath::V3d(box.max) - Imath::V3d(box.min);
  return d.x * d.y + d.y * d.z + d.z * d.x;
}

// MacDonald and Booth, "Heuristics for ray tracing using space subdivision", 1990; the bonus for empty space as in pbrt.
class CostModel {
 public:
  CostModel(const Config& config, const Imath::Box3f& box) : config_(config), box_(box), area_(half_area(box)) {}

  // Probability of entering each child when the node is entered.
  [[nodiscard]] double left_probability(int axis, float position) const {
    return part_area(axis, static_cast<double>(position) - box_.min[axis]) / area_;
  }
  [[nodiscard]] double right_probability(int axis, float position) const {
    return part_area(axis, static_cast<double>(box_.max[axis]) - position) / area_;
  }
  [[nodiscard]] double split_cost(int axis, float position, size_t left, size_t right) const {
    double triangles = config_.triangle_cost * (left_probability(axis, position) * static_cast<double>(left) +
                                                right_probability(axis, position) * static_cast<double>(right));
    if (left == 0 || right == 0) triangles *= 1.0 - config_.empty_bonus;
    return config_.traversal_cost + triangles;
  }
  [[nodiscard]] double leaf_cost(size_t count) const { return config_.triangle_cost * static_cast<double>(count); }
  // A box without area (one point, or a line) is never entered: it is not worth splitting.
  [[nodiscard]] bool splittable() const { return area_ > 0.0; }

 private:
  [[nodiscard]] double part_area(int axis, double extent) const {
    const int j = axis == 2 ? 0 : axis + 1, k = j == 2 ? 0 : j + 1;
    const double dj = static_cast<double>(box_.max[j]) - box_.min[j];
    const double dk = static_cast<double>(box_.max[k]) - box_.min[k];
    return dj * dk + extent * (dj + dk);
  }

  const Config& config_;
  const Imath::Box3f& box_;
  double area_;
};

// Buffers of the exact search, kept between nodes of one task.
struct SplitScratch {
  std::vector<float> starts, ends, planars;
  std::vector<uint32_t> keys, sorted_keys;
};

// Tries every bound of every reference. None if no plane lies strictly inside the box.
[[nodiscard]] std::optional<Split> best_split_exact(const Config& config, const Imath::Box3f& box,
                                                    std::span<const Reference> references, SplitScratch& scratch);

// Tries the borders of kBins bins per axis and the ends of the occupied space; counts are exact up to one bin. Parallel for
// many references; the result does not depend on the number of threads.
[[nodiscard]] std::optional<Split> best_split_binned(const Config& config, const Imath::Box3f& box,
                                                     std::span<const Reference> references);

} // namespace kindling::accel::kd
