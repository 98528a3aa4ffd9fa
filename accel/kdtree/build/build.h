// Builds the binary kd-tree over a list of geometries.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/binary_tree.h"
#include "accel/kdtree/build/reference.h"
#include "accel/kdtree/config.h"

#include <ImathBox.h>

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace kindling::accel::kd {

// Cancellation and progress for all trees of an accelerator together. Thread-safe.
class BuildMonitor {
 public:
  BuildMonitor(const BuildOptions& options, size_t total_triangles)
      : options_(options), total_(static_cast<double>(std::max<size_t>(1, total_triangles))) {}

  [[nodiscard]] bool cancelled() const {
    return options_.cancel != nullptr && options_.cancel->load(std::memory_order_relaxed);
  }
  // Adds finished work, measured in triangles.
  void add(double triangles) {
    if (!options_.on_progress) return;
    std::lock_guard lock(mutex_);
    done_ += triangles;
    const double fraction = std::min(1.0, done_ / total_);
    if (fraction < reported_ + 0.005) return;
    reported_ = fraction;
    options_.on_progress(fraction);
  }

 private:
  const BuildOptions& options_;
  double total_;
  std::mutex mutex_;
  double done_ = 0.0, reported_ = 0.0;
};

struct BinaryTree {
  BinaryNode root;
  Imath::Box3f bounds;           // bounds of all triangles that can be hit
  size_t triangle_count = 0;     // triangles that can be hit
  std::vector<TreeArena> arenas; // own the nodes below the root
};

// Builds a tree that is the same for any number of threads. A tree with more references than
// Config::expected_references() is built twice, the second time with at most as many. After a
// cancellation the tree is incomplete; check the monitor.
[[nodiscard]] BinaryTree build_binary_tree(const Config& config, std::span<const Geometry> geometries,
                                           BuildMonitor& monitor);

} // namespace kindling::accel::kd
