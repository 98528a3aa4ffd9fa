// Grid arithmetic of tiles, blocks and regions; lengths of passes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/tile_scheduler.h"

#include <algorithm>

namespace kindling {
namespace {

// Returns the largest multiple of `step` that is not above `x`, for negative x as well.
int floor_to(int x, int step) {
  const int quotient = x / step - (x % step != 0 && x < 0 ? 1 : 0);
  return quotient * step;
}

std::vector<PixelRect> cut(const PixelRect& area, int side) {
  std::vector<PixelRect> cells;
  for (int y = floor_to(area.min.y, side); y < area.max.y; y += side)
    for (int x = floor_to(area.min.x, side); x < area.max.x; x += side) {
      const PixelRect cell{V2i(std::max(x, area.min.x), std::max(y, area.min.y)),
                           V2i(std::min(x + side, area.max.x), std::min(y + side, area.max.y))};
      if (!cell.empty()) cells.push_back(cell);
    }
  return cells;
}

// Returns the multiple of kBlockSize nearest to begin + share (end - begin) strictly between the
// two; `end` if none is.
int cut_between(int begin, int end, double share) {
  const int first = floor_to(begin, kBlockSize) + kBlockSize;
  const int last = floor_to(end - 1, kBlockSize);
  if (first > last) return end;
  const double at = begin + share * (end - begin);
  return std::clamp(floor_to(static_cast<int>(at) + kBlockSize / 2, kBlockSize), first, last);
}

void divide(const PixelRect& area, int workers, std::vector<PixelRect>& regions) {
  if (workers == 1) {
    regions.push_back(area);
    return;
  }
  const int first_half = workers / 2;
  const double share = static_cast<double>(first_half) / workers;
  PixelRect first = area, second = area;
  const auto cut = [&](int axis) {
    const int at = cut_between(area.min[axis], area.max[axis], share);
    if (area.empty() || at == area.max[axis]) return false;
    first.max[axis] = second.min[axis] = at;
    return true;
  };
  const int longer = area.width() >= area.height() ? 0 : 1;
  if (!cut(longer) && !cut(1 - longer)) { // a single block
    second.min = second.max = area.max;
  }
  divide(first, first_half, regions);
  divide(second, workers - first_half, regions);
}

} // namespace

std::string_view schedule_name(Schedule schedule) { return schedule == Schedule::tiles ? "tiles" : "regions"; }

std::optional<Schedule> schedule_from_name(std::string_view name) {
  for (const Schedule schedule : {Schedule::tiles, Schedule::regions})
    if (schedule_name(schedule) == name) return schedule;
  return std::nullopt;
}

std::vector<PixelRect> make_regions(const PixelRect& crop, int workers) {
  std::vector<PixelRect> regions;
  divide(crop, workers, regions);
  return regions;
}

std::vector<PixelRect> make_tiles(const PixelRect& crop, int tile_size_px) { return cut(crop, tile_size_px); }

std::vector<PixelRect> make_blocks(const PixelRect& tile) { return cut(tile, kBlockSize); }

size_t count_blocks(const PixelRect& tile) {
  const auto along = [](int begin, int end) {
    return static_cast<size_t>((floor_to(end - 1, kBlockSize) - floor_to(begin, kBlockSize)) / kBlockSize + 1);
  };
  return along(tile.min.x, tile.max.x) * along(tile.min.y, tile.max.y);
}

PixelRect block_of(const PixelRect& tile, size_t index) {
  const V2i first(floor_to(tile.min.x, kBlockSize), floor_to(tile.min.y, kBlockSize));
  const int columns = (floor_to(tile.max.x - 1, kBlockSize) - first.x) / kBlockSize + 1;
  const auto at = static_cast<int>(index);
  const V2i corner = first + V2i(at % columns, at / columns) * kBlockSize;
  return {V2i(std::max(corner.x, tile.min.x), std::max(corner.y, tile.min.y)),
          V2i(std::min(corner.x + kBlockSize, tile.max.x), std::min(corner.y + kBlockSize, tile.max.y))};
}

SampleRange next_pass(uint32_t done, uint32_t total, double passes_per_second) {
  constexpr double kPassSeconds = 0.5; // maximum delay of a cancelled render
  constexpr uint32_t kMaxPassSamples = 64;
  const double affordable = std::max(1.0, passes_per_second * kPassSeconds);
  auto count = static_cast<uint32_t>(std::min<double>(std::clamp(done, 1U, kMaxPassSamples), affordable));
  // A batch holds four samples of a whole block, so passes are multiples of four.
  if (count > 4) count -= count % 4;
  return {done, done + std::min(count, total - done)};
}

} // namespace kindling
