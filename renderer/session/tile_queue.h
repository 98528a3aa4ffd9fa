// Hands tiles to threads, pass after pass, without waits between passes.
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

// A tile that lacks samples after its pass is queued for the next pass, behind the other tiles. A
// thread that finds no tile of a pass opens the next one. At most kOpenPasses are open at once,
// which bounds how far blocks can differ. If no tile is free, a thread helps with the tile of
// another, block by block, so that no thread waits longer than a block takes.
//
// All functions may be called from any thread.
class TileQueue {
 public:
  static constexpr uint64_t kOpenPasses = 2;

  // The threads at the end of a pass: they continue with the next one, or one pass is open at a
  // time and its end pauses, so that no block is ahead.
  enum class PassEnd { continues, pauses };

  // A tile in work. Each of its blocks goes to one of the threads that work on it.
  struct alignas(64) Visit {
    PixelRect tile;
    SampleRange samples; // of its pass
    std::atomic<size_t> next_block{0};
    std::atomic<size_t> unfinished{
        0}; // blocks that lack samples after this pass; counted by the threads that render them
    std::atomic<bool> abandoned{false}; // set by a thread that has not finished its block: the tile is queued again
    // Used by the queue.
    size_t lane = 0, index = 0, block_count = 0;
    uint64_t pass = 0;
    int threads = 0;
  };

  // The result of leave().
  struct Left {
    double samples = 0.0; // finished so far, mean over the tiles; complete tiles count as having all opened passes
    std::optional<SampleRange> finished_pass; // set if this was its last tile
  };

  // `lanes`: tiles by lane; a thread takes tiles of its own lane only. plan() returns the samples
  // of the next pass, in order; empty ends the render after the open passes. It is called by one
  // thread at a time.
  TileQueue(std::vector<std::vector<PixelRect>> lanes, size_t threads, std::function<std::optional<SampleRange>()> plan,
            PassEnd pass_end = PassEnd::continues);

  // Returns a tile to work on until leave(), after waiting for one if necessary. Null if paused or
  // finished.
  [[nodiscard]] Visit* take(size_t lane);
  // Returns the next block of a tile; empty if all are taken, or if paused.
  [[nodiscard]] std::optional<PixelRect> next_block(Visit& visit) const;
  Left leave(Visit& visit);

  // Makes threads return after their current blocks. The rest of each tile is queued again.
  void pause();
  [[nodiscard]] bool paused() const { return paused_.load(std::memory_order_relaxed); }
  void resume();

  // Returns the number of tiles that lack samples.
  [[nodiscard]] size_t live_tiles() const;

 private:
  // A queued tile and the pass that it is queued for.
  struct Ready {
    uint64_t pass = 0;
    size_t tile = 0;
    // Orders a heap whose first entry is the earliest.
    bool operator<(const Ready& other) const { return pass != other.pass ? pass > other.pass : tile > other.tile; }
  };
  struct Lane {
    std::vector<PixelRect> tiles;
    std::vector<Ready> ready;
    size_t in_hand = 0;
  };
  struct Pass {
    SampleRange samples;
    size_t remaining = 0; // tiles that have not finished the pass
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
  std::unique_ptr<Visit[]> visits_; // one for each thread
  size_t visit_count_;
  std::function<std::optional<SampleRange>()> plan_;
  PassEnd pass_end_;
  std::array<Pass, kOpenPasses> passes_{};
  uint64_t opened_ = 0;   // passes
  uint64_t finished_ = 0; // passes
  double finished_samples_ = 0.0;
  bool closed_ = false; // no more passes will open
  size_t tile_count_ = 0;
  size_t live_ = 0;
  std::atomic<bool> paused_{false};
};

} // namespace kindling
