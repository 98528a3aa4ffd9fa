// The surface area heuristic, and three searches for the best splitting plane.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/build/node_references.h"
#include "accel/kdtree/build/reference.h"

#include "accel/kdtree/config.h"

#include <ImathBox.h>

#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace kindling::accel::kd {

struct Split {
  double cost = 0.0;
  float position = 0.0f; // strictly inside the box
  int axis = 0;
  bool planar_left = false; // triangles in the plane go to the left child
};

// Returns half the surface area of a box, in double: large scenes would overflow in float.
[[nodiscard]] inline double half_area(const Imath::Box3f& box) {
  const Imath::V3d d = Imath::V3d(box.max) - Imath::V3d(box.min);
  return d.x * d.y + d.y * d.z + d.z * d.x;
}

// The surface area heuristic of MacDonald and Booth, "Heuristics for ray tracing using space
// subdivision", 1990, with pbrt's bonus for empty space.
class CostModel {
 public:
  CostModel(const Config& config, const Imath::Box3f& box)
      : config_(config), box_(box), area_(half_area(box)), inverse_area_(1.0 / area_) {}

  // Probability of entering a child, given that the node is entered.
  [[nodiscard]] double left_probability(int axis, float position) const {
    return part_area(axis, static_cast<double>(position) - box_.min[axis]) * inverse_area_;
  }
  [[nodiscard]] double right_probability(int axis, float position) const {
    return part_area(axis, static_cast<double>(box_.max[axis]) - position) * inverse_area_;
  }
  [[nodiscard]] double split_cost(int axis, float position, size_t left, size_t right) const {
    double leaves =
        left_probability(axis, position) * leaf_cost(left) + right_probability(axis, position) * leaf_cost(right);
    if (left == 0 || right == 0) leaves *= 1.0 - config_.empty_bonus;
    return config_.traversal_cost + leaves;
  }
  [[nodiscard]] double leaf_cost(size_t count) const {
    if (count == 0) return 0.0;
    return config_.leaf_cost + config_.triangle_cost * static_cast<double>(count);
  }
  // False for a box without area (a point or a line), which is never entered.
  [[nodiscard]] bool splittable() const { return area_ > 0.0; }
  [[nodiscard]] double area() const { return area_; }
  [[nodiscard]] const Config& config() const { return config_; }

 private:
  [[nodiscard]] double part_area(int axis, double extent) const {
    const int j = axis == 2 ? 0 : axis + 1, k = j == 2 ? 0 : j + 1;
    const double dj = static_cast<double>(box_.max[j]) - box_.min[j];
    const double dk = static_cast<double>(box_.max[k]) - box_.min[k];
    return dj * dk + extent * (dj + dk);
  }

  const Config& config_;
  const Imath::Box3f& box_;
  double area_, inverse_area_;
};

// A list that grows without initializing elements, and keeps its memory.
class EventList {
 public:
  // Makes room for `count` floats; what the list had is lost.
  [[nodiscard]] float* room_for(size_t count) {
    if (room_.size() < count) room_.resize(count);
    size_ = 0;
    return room_.data();
  }
  void set_size(size_t size) { size_ = size; }
  [[nodiscard]] size_t size() const { return size_; }
  [[nodiscard]] const float& operator[](size_t i) const { return room_[i]; }
  [[nodiscard]] std::span<float> all() { return {room_.data(), size_}; }
  [[nodiscard]] std::span<const float> all() const { return {room_.data(), size_}; }

 private:
  std::vector<float> room_;
  size_t size_ = 0;
};

// Buffers of the search by sorting, reused between nodes of one task.
struct SplitScratch {
  EventList starts, ends, planars;
  std::vector<uint32_t> keys, sorted_keys;
};

// Tries every bound of every reference, by sorting. Returns nullopt if no plane lies strictly
// inside the box.
[[nodiscard]] std::optional<Split> best_split_sorted(const Config& config, const Imath::Box3f& box,
                                                     const NodeReferences& references, SplitScratch& scratch);

// Tries every bound by counting the references on each side, in quadratic time, which is faster for
// few references. One run of 1 to kMaxCounted references. Costs are in single precision, and axes
// shorter than kMinExtent are not split. Splits that cost more than `limit` may be missed.
inline constexpr size_t kMaxCounted = 128;
inline constexpr float kMinExtent = 1e-30f;
[[nodiscard]] std::optional<Split> best_split_counted(const Config& config, const Imath::Box3f& box,
                                                      const NodeReferences& references,
                                                      double limit = std::numeric_limits<double>::infinity());

// Tries the borders of 32 to 256 bins per axis and the ends of the occupied space. For up to
// Config::refine_below references, also tries all bounds in the two bins at the best border.
// Parallel for many references; the result does not depend on the number of threads. The cost may
// be off by the few references that rounding puts into the wrong bin.
[[nodiscard]] std::optional<Split> best_split_binned(const Config& config, const Imath::Box3f& box,
                                                     const NodeReferences& references, SplitScratch& scratch);

// Tries the planes off the flat references at the ends of the occupied space, in a node that would
// be a leaf. The cost counts the boxes of what is on both sides, not the cells. `rays`: triangles
// of the tree over its half area. Returns nullopt unless enough is gained (Config::wall_min_gain).
[[nodiscard]] std::optional<Split> best_split_at_wall(const Config& config, const Imath::Box3f& box,
                                                      const NodeReferences& references, double rays);

// Tries every bound inside [low, high] on one axis; replaces `best` if one is cheaper.
void refine_split(const Config& config, const Imath::Box3f& box, const NodeReferences& references, int axis, float low,
                  float high, SplitScratch& scratch, std::optional<Split>& best);

} // namespace kindling::accel::kd
