// Every block of every pass is handed out once, for any number of threads and any pauses.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/run_workers.h"
#include "renderer/session/tile_queue.h"
#include "renderer/session/tile_scheduler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <stdexcept>
#include <thread>

namespace kindling {
namespace {

const PixelRect kQueueArea{V2i(3, 5), V2i(75, 53)};
constexpr uint32_t kPasses = 6;

std::function<std::optional<SampleRange>()> one_by_one(uint32_t& opened, uint32_t passes = kPasses) {
  return [&opened, passes]() -> std::optional<SampleRange> {
    if (opened == passes) return std::nullopt;
    ++opened;
    return SampleRange{opened - 1, opened};
  };
}

std::vector<std::vector<PixelRect>> lanes_of(size_t count, int tile_size_px) {
  std::vector<std::vector<PixelRect>> lanes;
  for (const PixelRect& region : make_regions(kQueueArea, static_cast<int>(count)))
    lanes.push_back(make_tiles(region, tile_size_px));
  return lanes;
}

TEST(TileQueue, HandsOutEveryBlockOfEveryPassOnce) {
  for (const size_t threads : {1U, 2U, 7U})
    for (const bool regions : {false, true})
      for (const int tile_size_px : {8, 32}) {
        Coverage coverage(kQueueArea); // written by the thread that has the block; adding a sample twice fails
        uint32_t opened = 0;
        const auto lanes = lanes_of(regions ? threads : 1, tile_size_px);
        TileQueue queue(lanes, threads, one_by_one(opened));
        std::atomic<int> wrong{0};
        std::mutex mutex;
        uint32_t last_finished = 0;
        double max_samples = 0.0;
        for (uint32_t round = 0; queue.live_tiles() > 0 && round < 10000; ++round) {
          std::atomic<uint32_t> left{1 + (round * 7919) % 29}; // blocks until the next pause
          run_workers(
              threads,
              [&](size_t thread) {
                while (TileQueue::Visit* visit = queue.take(regions ? thread : 0)) {
                  while (const std::optional<PixelRect> block = queue.next_block(*visit)) {
                    const size_t index = coverage.index_of(block->min);
                    const uint32_t done = coverage.done(index, {0, kPasses});
                    // In order; a block that was done before a pause may be asked for again.
                    if (done < visit->samples.first || done > visit->samples.end) ++wrong;
                    if (done == visit->samples.first && !coverage.add(index, visit->samples)) ++wrong;
                    if (!coverage.complete(index, {0, kPasses})) ++visit->unfinished;
                    if (--left == 0) queue.pause();
                  }
                  const TileQueue::Left found = queue.leave(*visit);
                  const std::lock_guard lock(mutex);
                  max_samples = std::max(max_samples, found.samples);
                  if (found.finished_pass) last_finished = std::max(last_finished, found.finished_pass->end);
                }
              },
              [&] { queue.pause(); });
          queue.resume();
        }
        EXPECT_EQ(wrong, 0);
        EXPECT_EQ(queue.live_tiles(), 0U);
        EXPECT_EQ(opened, kPasses);
        EXPECT_EQ(last_finished, kPasses);
        EXPECT_NEAR(max_samples, kPasses, 1e-9);
        for (size_t i = 0; i < coverage.block_count(); ++i) EXPECT_TRUE(coverage.complete(i, {0, kPasses})) << i;
      }
}

TEST(TileQueue, ThreadsShareTheLastTiles) {
  uint32_t opened = 0;
  TileQueue queue({make_tiles({V2i(0, 0), V2i(32, 16)}, 16)}, 3, one_by_one(opened, 1));
  TileQueue::Visit* first = queue.take(0);
  TileQueue::Visit* second = queue.take(0);
  ASSERT_TRUE(first && second);
  EXPECT_NE(first, second);
  EXPECT_EQ(first->tile, (PixelRect{V2i(0, 0), V2i(16, 16)})); // in order
  EXPECT_TRUE(queue.next_block(*first));
  TileQueue::Visit* third = queue.take(0);
  EXPECT_EQ(third, second); // which has more blocks left
  EXPECT_TRUE(queue.next_block(*third));
  while (queue.next_block(*second)) {
  }
  while (queue.next_block(*first)) {
  }
  EXPECT_FALSE(queue.leave(*second).finished_pass);
  EXPECT_FALSE(queue.leave(*first).finished_pass);
  const TileQueue::Left last = queue.leave(*third);
  ASSERT_TRUE(last.finished_pass);
  EXPECT_EQ(*last.finished_pass, (SampleRange{0, 1}));
  EXPECT_EQ(last.samples, 1.0);
  EXPECT_EQ(queue.live_tiles(), 0U);
}

// A pass ends for all threads before a block of the next one is handed out.
TEST(TileQueue, PausesAfterEachPass) {
  uint32_t opened = 0;
  const auto lanes = lanes_of(1, 8);
  TileQueue queue(lanes, 3, one_by_one(opened), TileQueue::PassEnd::pauses);
  const auto blocks = static_cast<int>(lanes.front().size());
  for (uint32_t pass = 0; pass < kPasses; ++pass) {
    std::atomic<int> handed_out{0}, of_other_passes{0}, finished{0};
    run_workers(
        3,
        [&](size_t) {
          while (TileQueue::Visit* visit = queue.take(0)) {
            if (visit->samples.first != pass) ++of_other_passes;
            while (queue.next_block(*visit)) {
              ++handed_out;
              if (pass + 1 < kPasses) ++visit->unfinished;
            }
            if (queue.leave(*visit).finished_pass) ++finished;
          }
        },
        [&] { queue.pause(); });
    EXPECT_EQ(handed_out, blocks) << pass;
    EXPECT_EQ(of_other_passes, 0) << pass;
    EXPECT_EQ(finished, 1) << pass;
    EXPECT_TRUE(queue.paused());
    queue.resume();
  }
  EXPECT_EQ(queue.live_tiles(), 0U);
  EXPECT_EQ(queue.take(0), nullptr);
}

// A lane that is finished early does not run ahead.
TEST(TileQueue, OpensAtMostTwoPasses) {
  uint32_t opened = 0;
  TileQueue queue({make_tiles({V2i(0, 0), V2i(8, 8)}, 8), make_tiles({V2i(8, 0), V2i(16, 8)}, 8)}, 2,
                  one_by_one(opened, 100));
  TileQueue::Visit* slow = queue.take(1);
  ASSERT_TRUE(slow);
  std::atomic<int> taken{0};
  {
    const std::jthread fast([&] {
      while (TileQueue::Visit* visit = queue.take(0)) {
        while (queue.next_block(*visit)) ++visit->unfinished;
        ++taken;
        queue.leave(*visit);
      }
    });
    while (taken < 2) std::this_thread::yield();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_EQ(taken, 2);
    EXPECT_EQ(opened, 2U);
    while (queue.next_block(*slow)) ++slow->unfinished;
    EXPECT_TRUE(queue.leave(*slow).finished_pass);
    while (taken < 3) std::this_thread::yield();
    queue.pause();
  }
  EXPECT_EQ(taken, 3);
}

TEST(TileQueue, ExceptionEndsAllThreads) {
  uint32_t opened = 0;
  TileQueue queue(lanes_of(1, 8), 3, one_by_one(opened, 1000000));
  const auto work = [&](size_t thread) {
    while (TileQueue::Visit* visit = queue.take(0)) {
      if (thread == 1) throw std::runtime_error("no memory");
      while (queue.next_block(*visit)) ++visit->unfinished;
      queue.leave(*visit);
    }
  };
  EXPECT_THROW(run_workers(3, work, [&] { queue.pause(); }), std::runtime_error);
}

} // namespace
} // namespace kindling
