// Sorted, disjoint spans of samples by block.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/coverage.h"

#include <algorithm>
#include <cassert>

namespace kindling {
namespace {

// Returns the columns (or rows) of the grid that hold [begin, end).
int blocks_between(int begin, int end) { return (end + kBlockSize - 1) / kBlockSize - begin / kBlockSize; }

} // namespace

Coverage::Coverage(const PixelRect& area) : area_(area) {
  if (area.empty()) return;
  blocks_.resize(static_cast<size_t>(columns()) * static_cast<size_t>(blocks_between(area.min.y, area.max.y)));
}

int Coverage::columns() const { return blocks_between(area_.min.x, area_.max.x); }

PixelRect Coverage::block(size_t index) const {
  const auto columns = static_cast<size_t>(this->columns());
  const V2i at((static_cast<int>(index % columns) + area_.min.x / kBlockSize) * kBlockSize,
               (static_cast<int>(index / columns) + area_.min.y / kBlockSize) * kBlockSize);
  return {V2i(std::max(at.x, area_.min.x), std::max(at.y, area_.min.y)),
          V2i(std::min(at.x + kBlockSize, area_.max.x), std::min(at.y + kBlockSize, area_.max.y))};
}

size_t Coverage::index_of(const V2i& pixel) const {
  assert(pixel.x >= area_.min.x && pixel.y >= area_.min.y && pixel.x < area_.max.x && pixel.y < area_.max.y);
  const int column = pixel.x / kBlockSize - area_.min.x / kBlockSize;
  const int row = pixel.y / kBlockSize - area_.min.y / kBlockSize;
  return static_cast<size_t>(row) * static_cast<size_t>(columns()) + static_cast<size_t>(column);
}

bool Coverage::add(size_t index, const SampleRange& samples) {
  if (samples.empty()) return true;
  std::vector<SampleRange>& spans = blocks_[index].spans;
  // The first span that ends at or after the beginning of the new one.
  auto next = std::lower_bound(spans.begin(), spans.end(), samples.first,
                               [](const SampleRange& span, uint32_t first) { return span.end < first; });
  const bool extends = next != spans.end() && next->end == samples.first;
  const auto after = extends ? next + 1 : next;
  if (after != spans.end() && after->first < samples.end) return false;
  const bool precedes = after != spans.end() && after->first == samples.end;
  if (extends && precedes) {
    next->end = after->end;
    spans.erase(after);
  } else if (extends) {
    next->end = samples.end;
  } else if (precedes) {
    after->first = samples.first;
  } else {
    spans.insert(next, samples);
  }
  return true;
}

SampleRange Coverage::first_missing(size_t index, const SampleRange& wanted) const {
  SampleRange missing = wanted;
  for (const SampleRange& span : blocks_[index].spans) {
    if (span.end <= missing.first) continue;
    if (span.first > missing.first) {
      missing.end = std::min(missing.end, span.first);
      break;
    }
    missing.first = std::min(span.end, wanted.end);
  }
  return missing;
}

uint32_t Coverage::done(size_t index, const SampleRange& wanted) const {
  return first_missing(index, wanted).first - wanted.first;
}

bool Coverage::complete(size_t index, const SampleRange& wanted) const {
  return blocks_[index].stopped || first_missing(index, wanted).empty();
}

double Coverage::done_share(const SampleRange& wanted) const {
  double done = 0.0, all = 0.0;
  for (size_t i = 0; i < blocks_.size() && !wanted.empty(); ++i) {
    const auto pixels = static_cast<double>(block(i).pixel_count());
    all += pixels * wanted.count();
    if (blocks_[i].stopped) {
      done += pixels * wanted.count();
      continue;
    }
    for (const SampleRange& span : blocks_[i].spans) {
      const SampleRange common{std::max(span.first, wanted.first), std::min(span.end, wanted.end)};
      if (!common.empty()) done += pixels * common.count();
    }
  }
  return all > 0.0 ? done / all : 1.0;
}

} // namespace kindling
