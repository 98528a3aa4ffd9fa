// Stream traversal: many independent rays in flight through one tree to hide latency.
//
// A round takes every ray at a node down by one box node, then every ray at a leaf through one of
// its blocks, then returns the finished rays and refills their slots (stream_steps.h).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/stream_steps.h"

namespace kindling::accel::kd::KINDLING_SIMD {

// Meant for the stack; nothing is initialized before its use.
template <bool kAny, class Hits = BestHits>
class Stream : StreamSteps<kAny, OneTree, Hits> {
  using Steps = StreamSteps<kAny, OneTree, Hits>;
  using Steps::at_node_, Steps::at_leaf_, Steps::done_, Steps::done_count_, Steps::free_, Steps::free_count_,
      Steps::filter_, Steps::hits_, Steps::prepared_, Steps::next_, Steps::waiting_;
  using typename Steps::Slot;

 public:
  explicit Stream(const Tree& tree, const HitFilter& filter, Hits hits = {}) : Steps({tree}, filter, hits) {}

  // Calls finish(ray index, hit) once for each ray that hits something, in any order, with the
  // nearest hit or, if kAny, any hit. Never calls it if another kind takes the hits.
  template <class Finish>
  void trace(std::span<const Ray> rays, const Finish& finish) {
    if (tree().root == kEmptyChild) return;
    this->free_all_slots();
    const auto prepare_rays = [&] { prepare(rays, finish); };
    const auto begin = [this](uint32_t offset, uint32_t i) {
      this->slot(offset).ray = static_cast<uint32_t>(first_prepared_ + i);
      this->begin_tree(offset, tree().root);
    };
    while (true) {
      this->fill(rays.size(), prepare_rays, begin);
      if (at_node_.count + at_leaf_.count == 0 || filter_.abandoned()) break;
      this->descend();
      this->test_leaves(rays);
      for (uint32_t k = 0; k < done_count_; ++k) {
        const Slot& ended = this->slot(done_[k]);
        if (ended.primitive != kNoId) finish(ended.ray, ended.best());
        free_[free_count_++] = done_[k];
      }
      done_count_ = 0;
    }
  }

 private:
  [[nodiscard]] const Tree& tree() const { return this->trees_.tree; }

  template <class Finish>
  void prepare(std::span<const Ray> rays, const Finish& finish) {
    const std::span<const Ray> part = rays.subspan(next_, std::min<size_t>(kRayLanes, rays.size() - next_));
    prepared_.prepare(part, tree().clip_bounds);
    waiting_ = prepared_.enter;
    first_prepared_ = next_;
    next_ += part.size();
    for (uint32_t apart = prepared_.apart; apart != 0; apart &= apart - 1) {
      const size_t i = first_prepared_ + static_cast<size_t>(std::countr_zero(apart));
      if constexpr (Steps::kEvery)
        hits_.leave_aside(static_cast<uint32_t>(i));
      else
        trace_indexed<kAny>(tree(), filter_, rays, i, finish);
    }
  }

  size_t first_prepared_ = 0; // index of the first prepared ray
};

} // namespace kindling::accel::kd::KINDLING_SIMD
