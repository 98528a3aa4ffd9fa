// Coverage: the samples that each block of an image has.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/film.h"
#include "renderer/integrator/integrator.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

// Samples of one block. Spans are sorted, disjoint, and never touch.
struct BlockCoverage {
  std::vector<SampleRange> spans;
  bool stopped = false; // by adaptive sampling
  bool operator==(const BlockCoverage&) const = default;
};

// The coverage of all blocks that `area` touches, in scan order of the grid with side kBlockSize
// through the image's origin. Blocks at the border of the area are cut to it. A block's entry may
// be written by the thread that owns its tile, as in Film.
class Coverage {
 public:
  Coverage() = default;
  explicit Coverage(const PixelRect& area);

  [[nodiscard]] const PixelRect& area() const { return area_; }
  [[nodiscard]] size_t block_count() const { return blocks_.size(); }
  [[nodiscard]] PixelRect block(size_t index) const;     // in pixels
  [[nodiscard]] size_t index_of(const V2i& pixel) const; // of the block with this pixel, inside area()
  [[nodiscard]] const BlockCoverage& operator[](size_t index) const { return blocks_[index]; }

  // Returns false and changes nothing if the block already has one of the samples.
  bool add(size_t index, const SampleRange& samples);
  void set_stopped(size_t index) { blocks_[index].stopped = true; }

  // Returns the first contiguous range of `wanted` that the block lacks; empty if it lacks none.
  [[nodiscard]] SampleRange first_missing(size_t index, const SampleRange& wanted) const;
  // Returns the number of samples that the block has without a gap from wanted.first on.
  [[nodiscard]] uint32_t done(size_t index, const SampleRange& wanted) const;
  // Returns the share of `wanted` that all pixels have, in [0, 1]. A stopped block lacks none. 1 if
  // `wanted` is empty.
  [[nodiscard]] double done_share(const SampleRange& wanted) const;
  // Returns whether the block has all of `wanted`, or has stopped.
  [[nodiscard]] bool complete(size_t index, const SampleRange& wanted) const;

  bool operator==(const Coverage&) const = default;

 private:
  [[nodiscard]] int columns() const;

  PixelRect area_;
  std::vector<BlockCoverage> blocks_;
};

} // namespace kindling
