// The upper level: an eight-wide bounding volume hierarchy over the boxes of instances.
//
// Instances overlap and are few, so object splits serve better than planes, which would put one
// instance into many leaves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/aligned_array.h"
#include "accel/kdtree/instance_node.h"

#include <ImathBox.h>
#include <ImathVec.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kindling::accel::kd {

class InstanceLevel {
 public:
  InstanceLevel() = default;
  // Builds over world-space boxes, conservative and none of them empty. Parallel; the result is the
  // same for any number of threads. `cancel`: null, or polled; a cancelled build is empty.
  // `growth`: the largest rounding_growth() of the instances; a ray's transform moves it by up to
  // transform_error(growth, its origin), which the traversal adds to the boxes.
  explicit InstanceLevel(std::vector<Imath::Box3f> boxes, const std::atomic<bool>* cancel = nullptr,
                         float growth = 1.0f);

  [[nodiscard]] bool empty() const { return nodes_.size() == 0; }
  [[nodiscard]] size_t node_count() const { return nodes_.size(); }
  // Returns the largest number of nodes on a path from the root.
  [[nodiscard]] uint32_t depth() const { return depth_; }
  [[nodiscard]] size_t memory_bytes() const { return nodes_.size() * sizeof(Node); }

  // For the traversal (kernels/instances.h).
  using Node = InstanceNode;
  static constexpr uint32_t kBoxBit = Node::kBoxBit;
  static constexpr uint32_t kNone = Node::kNone;
  static constexpr uint32_t kSahDepth = 40; // deeper parts are halved, which bounds the depth and so the stack
  static_assert(kSahDepth + 32 == Node::kMaxDepth);
  static constexpr size_t kStackSize = 7 * Node::kMaxDepth + 9;
  // Returns the distance in world space by which boxes are widened for a ray from this origin.
  [[nodiscard]] float margin(const Imath::V3f& origin) const { return box_margin(growth_, origin); }
  [[nodiscard]] float growth() const { return growth_; }
  // Returns a node by index; node 0 is the root.
  [[nodiscard]] const Node& node(uint32_t number) const { return nodes_[number]; }
  [[nodiscard]] std::span<const Node> nodes() const { return {nodes_.data(), nodes_.size()}; }

 private:
  AlignedArray<Node> nodes_;
  uint32_t depth_ = 0;
  float growth_ = 1.0f;
};

} // namespace kindling::accel::kd
