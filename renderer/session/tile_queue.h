// Hands tiles out to threads, pass after pass. Threads do not wait for each other between passes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/coverage.h"

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

namespace kindling {

// A tile that still wants samples when its pass is over comes back for the next one, behind the other tiles: who finds no tile of a
// pass goes on with the next pass, which opens then. At most kOpenPasses are open at once, so that blocks differ by no more. Where no tile is
// free a thread helps with one that another has in hand, block by block: at the end none waits longer than for a block.
//
// All functions may be called from any thread.
class TileQueue {
 public:
  static constexpr uint64_t kOpenPasses = 2;

  // A tile in hand: each of its blocks goes to one of the threads that are at it.
  struct alignas(64) Visit {
    PixelRect tile;
    SampleRange samples; // of the pass
    std::atomic<size_t> next_block{0};
    std::atomic<size_t> unfinished{0}; // blocks that want more samples after this pass; counted by whoever renders them
    // Of the queue.
    size_t lane = 0, index = 0, block_count = 0;
    uint64_t pass = 0;
    int threads = 0;
  };

  // What is known when a thread leaves a tile.
  struct Left {
    double samples = 0.0; // finished so far, mean over the tiles; those that want no more have all that were opened
    std::optional<SampleRange> finished_pass; // whose last tile it was
  };

  // `lanes`: tiles by lane; a thread takes tiles of its lane alone. plan(): the samples of the next pass, in order; empty ends the
  // render after the passes that are open. It is called by one thread at a time.
  TileQueue(std::vector<std::vector<PixelRect>> lanes, size_t threads,
            std::function<std::optional<SampleRange>()> plan);

  // A tile to work on, until leave(); waits for one if it must. Null: paused, or nothing is left to do.
  [[nodiscard]] Visit* take(size_t lane);
  // The next block of a tile; empty once all are taken, or paused.
  [[nodiscard]] std::optional<PixelRect> next_block(Visit& visit) const;
  Left leave(Visit& visit);

  // Lets threads go after the blocks in hand; tiles then keep what they have not done for later.
  void pause();
  [[nodiscard]] bool paused() const { return paused_.load(std::memory_order_relaxed); }
  void resume();

  // Tiles that want more samples.
  [[nodiscard]] size_t live_tiles() const;

 private:
  // A tile that waits, and the pass that it waits for.
  struct Ready {
    uint64_t pass = 0;
    size_t tile = 0;
    // Of a heap whose first is the earliest.
    bool operator<(const Ready& other) const { return pass != other.pass ? pass > other.pass : tile > other.tile; }
  };
  struct Lane {
    std::vector<PixelRect> tiles;
    std::vector<Ready> ready;
    size_t in_hand = 0;
  };
  struct Pass {
    SampleRange samples;
    size_t remaining = 0; // tiles that have not finished it
  };

  [[nodiscard]] bool may_start(uint64_t pass);
  [[nodiscard]] Visit& start(size_t lane);
  [[nodiscard]] Visit* join(size_t lane);
  void finish(const Visit& visit, Left& left);
  static void push(Lane& lane, const Ready& ready);
  [[nodiscard]] Pass& pass(uint64_t number) { return passes_[number % kOpenPasses]; }

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Lane> lanes_;
  std::unique_ptr<Visit[]> visits_; // one for each thread is enough: each of those in use has a thread
  size_t visit_count_;
  std::function<std::optional<SampleRange>()> plan_;
  std::array<Pass, kOpenPasses> passes_{};
  uint64_t opened_ = 0;   // passes
  uint64_t finished_ = 0; // passes
  double finished_samples_ = 0.0;
  bool closed_ = false; // no more passes
  size_t tile_count_ = 0;
  size_t live_ = 0;
  std::atomic<bool> paused_{false};
};

} // namespace kindling
