// Lanes of tiles, open passes, and the tiles in work.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/tile_queue.h"

#include "renderer/session/tile_scheduler.h"

#include <algorithm>
#include <cassert>

namespace kindling {

TileQueue::TileQueue(std::vector<std::vector<PixelRect>> lanes, size_t threads,
                     std::function<std::optional<SampleRange>()> plan, PassEnd pass_end)
    : visits_(std::make_unique<Visit[]>(threads)), visit_count_(threads), plan_(std::move(plan)), pass_end_(pass_end) {
  for (std::vector<PixelRect>& tiles : lanes) {
    Lane& lane = lanes_.emplace_back();
    lane.tiles = std::move(tiles);
    tile_count_ += lane.tiles.size();
    lane.ready.reserve(lane.tiles.size());
    for (size_t t = 0; t < lane.tiles.size(); ++t) lane.ready.push_back({0, t}); // in order, which is a heap
  }
  live_ = tile_count_;
}

TileQueue::Visit* TileQueue::take(size_t lane_index) {
  std::unique_lock lock(mutex_);
  Lane& lane = lanes_[lane_index];
  for (;;) {
    if (paused()) return nullptr;
    if (!lane.ready.empty() && may_start(lane.ready.front().pass)) return &start(lane_index);
    if (Visit* visit = join(lane_index)) return visit;
    if (lane.in_hand == 0 && (closed_ || lane.ready.empty())) return nullptr;
    changed_.wait(lock);
  }
}

// Opens the pass if it is the next one.
bool TileQueue::may_start(uint64_t number) {
  if (number < opened_) return true;
  assert(number == opened_);
  if (closed_ || opened_ - finished_ == (pass_end_ == PassEnd::pauses ? 1 : kOpenPasses)) return false;
  const std::optional<SampleRange> samples = plan_();
  if (!samples) {
    closed_ = true;
    changed_.notify_all();
    return false;
  }
  pass(opened_) = {*samples, live_};
  ++opened_;
  return true;
}

TileQueue::Visit& TileQueue::start(size_t lane_index) {
  Lane& lane = lanes_[lane_index];
  std::pop_heap(lane.ready.begin(), lane.ready.end());
  const Ready ready = lane.ready.back();
  lane.ready.pop_back();
  ++lane.in_hand;
  Visit* const visit =
      std::find_if(visits_.get(), visits_.get() + visit_count_, [](const Visit& v) { return v.threads == 0; });
  assert(visit != visits_.get() + visit_count_);
  visit->tile = lane.tiles[ready.tile];
  visit->samples = pass(ready.pass).samples;
  visit->next_block = visit->unfinished = 0;
  visit->abandoned = false;
  visit->lane = lane_index;
  visit->index = ready.tile;
  visit->block_count = count_blocks(visit->tile);
  visit->pass = ready.pass;
  visit->threads = 1;
  return *visit;
}

// Returns the tile in work with the most blocks left.
TileQueue::Visit* TileQueue::join(size_t lane_index) {
  Visit* best = nullptr;
  size_t max_left = 0;
  for (size_t i = 0; i < visit_count_; ++i) {
    Visit& visit = visits_[i];
    if (visit.threads == 0 || visit.lane != lane_index) continue;
    const size_t taken = visit.next_block;
    if (taken >= visit.block_count || visit.block_count - taken <= max_left) continue;
    max_left = visit.block_count - taken;
    best = &visit;
  }
  if (best) ++best->threads;
  return best;
}

std::optional<PixelRect> TileQueue::next_block(Visit& visit) const {
  if (paused()) return std::nullopt;
  const size_t block = visit.next_block++;
  if (block >= visit.block_count) return std::nullopt;
  return block_of(visit.tile, block);
}

TileQueue::Left TileQueue::leave(Visit& visit) {
  const std::lock_guard lock(mutex_);
  Left left;
  if (--visit.threads == 0) {
    Lane& lane = lanes_[visit.lane];
    --lane.in_hand;
    if (visit.next_block < visit.block_count || visit.abandoned)
      push(lane, {visit.pass, visit.index}); // paused; the coverage lists the finished blocks
    else
      finish(visit, left);
    changed_.notify_all();
  }
  left.samples = finished_samples_;
  for (uint64_t p = finished_; p < opened_; ++p)
    left.samples +=
        pass(p).samples.count() * (1.0 - static_cast<double>(pass(p).remaining) / static_cast<double>(tile_count_));
  return left;
}

void TileQueue::finish(const Visit& visit, Left& left) {
  if (visit.unfinished > 0) {
    --pass(visit.pass).remaining;
    push(lanes_[visit.lane], {visit.pass + 1, visit.index});
  } else {
    --live_;
    for (uint64_t p = visit.pass; p < opened_; ++p) --pass(p).remaining;
  }
  for (; finished_ < opened_ && pass(finished_).remaining == 0; ++finished_) {
    left.finished_pass = pass(finished_).samples;
    finished_samples_ += left.finished_pass->count();
    if (pass_end_ == PassEnd::pauses) paused_ = true;
  }
}

void TileQueue::push(Lane& lane, const Ready& ready) {
  lane.ready.push_back(ready);
  std::push_heap(lane.ready.begin(), lane.ready.end());
}

void TileQueue::pause() {
  const std::lock_guard lock(mutex_);
  paused_ = true;
  changed_.notify_all();
}

void TileQueue::resume() {
  const std::lock_guard lock(mutex_);
  paused_ = false;
}

size_t TileQueue::live_tiles() const {
  const std::lock_guard lock(mutex_);
  return live_;
}

} // namespace kindling
