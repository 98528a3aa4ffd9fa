// Finds the gaps of a coverage, merges them into rectangles and names them.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/gaps.h"

#include "renderer/distributed/work_parts.h"
#include "renderer/session/tile_scheduler.h"

#include <algorithm>
#include <map>

namespace kindling {

namespace {

constexpr size_t kMaxLines = 24;

PixelRect intersection(const PixelRect& a, const PixelRect& b) {
  return {V2i(std::max(a.min.x, b.min.x), std::max(a.min.y, b.min.y)),
          V2i(std::min(a.max.x, b.max.x), std::min(a.max.y, b.max.y))};
}

// The samples that one block lacks.
using Missing = std::vector<SampleRange>;

Missing missing_of(const BlockCoverage& block, uint32_t samples_per_pixel) {
  Missing missing;
  if (block.stopped) return missing;
  uint32_t next = 0;
  for (const SampleRange& span : block.spans) {
    if (span.first >= samples_per_pixel) break;
    if (span.first > next) missing.push_back({next, span.first});
    next = std::max(next, span.end);
  }
  if (next < samples_per_pixel) missing.push_back({next, samples_per_pixel});
  return missing;
}

std::string range_text(uint32_t first, uint32_t last) {
  return first == last ? std::to_string(first) : std::to_string(first) + "-" + std::to_string(last);
}

// "samples 21-41 and 63-84", "all samples".
std::string samples_text(const Missing& missing, uint32_t samples_per_pixel) {
  if (missing == Missing{{0, samples_per_pixel}}) return "all samples";
  const bool one = missing.size() == 1 && missing.front().count() == 1;
  std::string text = one ? "sample " : "samples ";
  for (size_t i = 0; i < missing.size(); ++i) {
    if (i > 0) text += i + 1 < missing.size() ? ", " : " and ";
    text += range_text(missing[i].first, missing[i].end - 1);
  }
  return text;
}

// "part 2/3: ", "parts 2-3/8 and 5/8: "; empty unless the gap consists of whole parts.
std::string sample_parts_text(const Missing& missing, uint32_t samples_per_pixel, uint32_t parts) {
  if (parts < 2 || parts > samples_per_pixel || missing == Missing{{0, samples_per_pixel}}) return {};
  const auto begin = [&](uint64_t k) { return static_cast<uint32_t>(samples_per_pixel * k / parts); };
  // Number of parts before `sample`, if a part begins there.
  const auto parts_until = [&](uint64_t sample) {
    return static_cast<uint32_t>((sample * parts + samples_per_pixel - 1) / samples_per_pixel);
  };
  std::string text;
  uint32_t named = 0;
  for (size_t i = 0; i < missing.size(); ++i) {
    const uint32_t first = parts_until(missing[i].first);
    const uint32_t last = parts_until(missing[i].end);
    if (begin(first) != missing[i].first || begin(last) != missing[i].end) return {};
    if (i > 0) text += i + 1 < missing.size() ? ", " : " and ";
    text += range_text(first + 1, last) + "/" + std::to_string(parts);
    named += last - first;
  }
  return (named == 1 ? "part " : "parts ") + text + ": ";
}

std::string pixels_text(const PixelRect& rect) {
  return std::to_string(rect.min.x) + "," + std::to_string(rect.min.y) + " to " + std::to_string(rect.max.x) + "," +
         std::to_string(rect.max.y);
}

// The grid of blocks of a coverage's area.
class BlockGrid {
 public:
  explicit BlockGrid(const Coverage& coverage) : coverage_(coverage) {
    while (columns_ < coverage.block_count() && coverage.block(columns_).min.y == coverage.area().min.y) ++columns_;
  }
  [[nodiscard]] size_t columns() const { return columns_; }
  [[nodiscard]] size_t rows() const { return columns_ == 0 ? 0 : coverage_.block_count() / columns_; }
  [[nodiscard]] PixelRect pixels(size_t column, size_t row, size_t end_column, size_t end_row) const {
    return {coverage_.block(row * columns_ + column).min,
            coverage_.block((end_row - 1) * columns_ + end_column - 1).max};
  }

 private:
  const Coverage& coverage_;
  size_t columns_ = 0;
};

constexpr size_t kComplete = ~size_t{0};

// Moves the blocks of one kind from `kinds` into rectangles: whole tile parts first, then in scan
// order, each first as wide and then as high as possible.
struct Place {
  PixelRect pixels;
  uint32_t tile_part = 0; // from 1
};
std::vector<Place> take_places(const Coverage& coverage, const BlockGrid& grid, size_t kind, std::vector<size_t>& kinds,
                               const std::vector<PixelRect>& tile_parts) {
  std::vector<Place> places;
  for (size_t k = 0; k < tile_parts.size(); ++k) {
    std::vector<size_t> blocks;
    for (const PixelRect& block : make_blocks(tile_parts[k])) blocks.push_back(coverage.index_of(block.min));
    const auto missing = [&](size_t index) { return kinds[index] == kind; };
    if (blocks.empty() || !std::all_of(blocks.begin(), blocks.end(), missing)) continue;
    for (const size_t index : blocks) kinds[index] = kComplete;
    places.push_back({tile_parts[k], static_cast<uint32_t>(k + 1)});
  }
  for (size_t row = 0; row < grid.rows(); ++row)
    for (size_t column = 0; column < grid.columns(); ++column) {
      const auto missing = [&](size_t c, size_t r) { return kinds[r * grid.columns() + c] == kind; };
      if (!missing(column, row)) continue;
      size_t end_column = column + 1;
      while (end_column < grid.columns() && missing(end_column, row)) ++end_column;
      const auto row_missing = [&](size_t r) {
        for (size_t c = column; c < end_column; ++c)
          if (!missing(c, r)) return false;
        return true;
      };
      size_t end_row = row + 1;
      while (end_row < grid.rows() && row_missing(end_row)) ++end_row;
      for (size_t r = row; r < end_row; ++r)
        for (size_t c = column; c < end_column; ++c) kinds[r * grid.columns() + c] = kComplete;
      places.push_back({grid.pixels(column, row, end_column, end_row), 0});
    }
  return places;
}

} // namespace

Gaps find_gaps(const Coverage& coverage, const PixelRect& crop, uint32_t samples_per_pixel, const PartCounts& counts) {
  Gaps gaps;
  // Blocks with the same missing samples are of one kind; kinds are numbered.
  std::map<Missing, size_t> number_of;
  std::vector<const Missing*> missing_by_kind;
  std::vector<size_t> kinds(coverage.block_count(), kComplete);
  std::vector<uint64_t> blocks_by_kind;
  for (size_t i = 0; i < coverage.block_count(); ++i) {
    const auto pixels = static_cast<uint64_t>(intersection(coverage.block(i), crop).pixel_count());
    Missing missing = missing_of(coverage[i], samples_per_pixel);
    if (coverage[i].spans.empty()) gaps.empty_pixels += pixels;
    if (missing.empty()) continue;
    for (const SampleRange& range : missing) gaps.missing_samples += pixels * range.count();
    const auto [found, is_new] = number_of.emplace(std::move(missing), missing_by_kind.size());
    if (is_new) {
      missing_by_kind.push_back(&found->first);
      blocks_by_kind.push_back(0);
    }
    kinds[i] = found->second;
    ++blocks_by_kind[found->second];
  }
  const BlockGrid grid(coverage);
  const std::vector<PixelRect> tile_parts =
      counts.tiles > 1 ? make_regions(crop, static_cast<int>(counts.tiles)) : std::vector<PixelRect>();
  size_t not_listed = 0;
  uint64_t pixels_not_listed = 0;
  for (size_t kind = 0; kind < missing_by_kind.size(); ++kind) {
    const Missing& missing = *missing_by_kind[kind];
    const std::string part = sample_parts_text(missing, samples_per_pixel, counts.samples);
    const std::string samples = samples_text(missing, samples_per_pixel);
    if (blocks_by_kind[kind] == coverage.block_count()) {
      gaps.lines.push_back(part + samples + " of all pixels");
      break;
    }
    for (const Place& place : take_places(coverage, grid, kind, kinds, tile_parts)) {
      const PixelRect pixels = intersection(place.pixels, crop);
      if (gaps.lines.size() >= kMaxLines) {
        ++not_listed;
        pixels_not_listed += static_cast<uint64_t>(pixels.pixel_count());
        continue;
      }
      std::string tiles;
      if (place.tile_part > 0) tiles = "tile part " + part_number_text({place.tile_part, counts.tiles}) + ": ";
      gaps.lines.push_back(tiles + part + samples + " of pixels " + pixels_text(pixels));
    }
  }
  if (not_listed > 0)
    gaps.lines.push_back("and at " + std::to_string(not_listed) + " other places, " +
                         std::to_string(pixels_not_listed) + " pixels in all");
  return gaps;
}

} // namespace kindling
