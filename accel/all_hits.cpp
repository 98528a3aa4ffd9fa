// Every crossing of many rays: blocks of rays in parallel, then their lists joined in order.
// SPDX-License-Identifier: Apache-2.0
#include "accel/all_hits.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>

namespace kindling::accel {
namespace {

constexpr size_t kBlock = 256; // rays per task

// The crossings of a block of rays, and how many each ray has.
struct BlockOfLists {
  std::vector<Crossing> crossings;
  std::vector<size_t> counts;
};

} // namespace

bool all_hits(const Accelerator& accelerator, std::span<const Ray> rays, size_t limit, CrossingLists& lists) {
  std::vector<BlockOfLists> blocks((rays.size() + kBlock - 1) / kBlock);
  std::atomic<bool> answered{true};
  tbb::parallel_for(size_t{0}, blocks.size(), [&](size_t b) {
    std::vector<Crossing> of_ray;
    for (const Ray& ray : rays.subspan(b * kBlock, std::min(kBlock, rays.size() - b * kBlock))) {
      if (!accelerator.all_hits(ray, limit, of_ray)) answered.store(false, std::memory_order_relaxed);
      blocks[b].crossings.insert(blocks[b].crossings.end(), of_ray.begin(), of_ray.end());
      blocks[b].counts.push_back(of_ray.size());
    }
  });
  lists.first.assign(1, 0);
  lists.first.reserve(rays.size() + 1);
  for (const BlockOfLists& block : blocks)
    for (const size_t count : block.counts) lists.first.push_back(lists.first.back() + count);
  lists.crossings.resize(lists.first.back());
  tbb::parallel_for(size_t{0}, blocks.size(), [&](size_t b) {
    std::copy(blocks[b].crossings.begin(), blocks[b].crossings.end(),
              lists.crossings.begin() + static_cast<std::ptrdiff_t>(lists.first[b * kBlock]));
    blocks[b] = {};
  });
  return answered.load();
}

} // namespace kindling::accel
