// Every crossing of many rays: blocks of rays in parallel, then their lists joined in order.
// SPDX-License-Identifier: Apache-2.0
#include "accel/all_hits.h"

#include "accel/kdtree/kdtree_accelerator.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cstdint>

namespace kindling::accel {
namespace {

constexpr size_t kBlock = 1024; // rays per task

// The crossings of a block of rays, and how many each ray has.
struct BlockOfLists {
  std::vector<Crossing> crossings;
  std::vector<uint32_t> counts;
};

// Returns false if the accelerator cannot answer.
bool trace(const Accelerator& accelerator, std::span<const Ray> rays, size_t limit, BlockOfLists& block) {
  block.counts.resize(rays.size());
  if (kdtree_all_hits(accelerator, rays, limit, block.crossings, block.counts)) return true;
  bool answered = true;
  std::vector<Crossing> of_ray;
  for (size_t i = 0; i < rays.size(); ++i) {
    answered = accelerator.all_hits(rays[i], limit, of_ray) && answered;
    block.crossings.insert(block.crossings.end(), of_ray.begin(), of_ray.end());
    block.counts[i] = static_cast<uint32_t>(of_ray.size());
  }
  return answered;
}

} // namespace

bool all_hits(const Accelerator& accelerator, std::span<const Ray> rays, size_t limit, CrossingLists& lists) {
  std::vector<BlockOfLists> blocks((rays.size() + kBlock - 1) / kBlock);
  std::atomic<bool> answered{true};
  tbb::parallel_for(size_t{0}, blocks.size(), [&](size_t b) {
    const auto part = rays.subspan(b * kBlock, std::min(kBlock, rays.size() - b * kBlock));
    if (!trace(accelerator, part, limit, blocks[b])) answered.store(false, std::memory_order_relaxed);
  });
  lists.first.assign(1, 0);
  lists.first.reserve(rays.size() + 1);
  for (const BlockOfLists& block : blocks)
    for (const uint32_t count : block.counts) lists.first.push_back(lists.first.back() + count);
  lists.crossings.resize(lists.first.back());
  tbb::parallel_for(size_t{0}, blocks.size(), [&](size_t b) {
    std::copy(blocks[b].crossings.begin(), blocks[b].crossings.end(),
              lists.crossings.begin() + static_cast<std::ptrdiff_t>(lists.first[b * kBlock]));
    blocks[b] = {};
  });
  return answered.load();
}

} // namespace kindling::accel
