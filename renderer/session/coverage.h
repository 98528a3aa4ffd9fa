// Which samples the blocks of an image have: what is done, what is missing, and what a merge may add up.
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
  bool stopped = false; // adaptive sampling wants no more than these
  bool operator==(const BlockCoverage&) const = default;
};

// By block of the grid with side kBlockSize through the image's origin, for the blocks that `area` touches, in scan order; blocks at its
// border are cut to it. A block's entry may be written by the thread that has its tile, as in Film.
class Coverage {
 public:
  Coverage() = default;
  explicit Coverage(const PixelRect& area);

  [[nodiscard]] const PixelRect& area() const { return area_; }
  [[nodiscard]] size_t block_count() const { return blocks_.size(); }
  [[nodiscard]] PixelRect block(size_t index) const;     // in pixels
  [[nodiscard]] size_t index_of(const V2i& pixel) const; // of the block with this pixel, which must be inside area()
  [[nodiscard]] const BlockCoverage& operator[](size_t index) const { return blocks_[index]; }

  // False, and nothing changes, if the block has one of them already.
  bool add(size_t index, const SampleRange& samples);
  void set_stopped(size_t index) { blocks_[index].stopped = true; }

  // The first samples of `wanted`, as many as follow each other, that the block has not; empty if it has all.
  [[nodiscard]] SampleRange first_missing(size_t index, const SampleRange& wanted) const;
  // How many samples of `wanted` the block has, counted from wanted.first without a gap.
  [[nodiscard]] uint32_t done(size_t index, const SampleRange& wanted) const;
  // Of `wanted` of all pixels, the share that is there, in [0, 1]; a block that has stopped lacks none. 1 where nothing is wanted.
  [[nodiscard]] double done_share(const SampleRange& wanted) const;
  // Whether the block has all of `wanted`, or has stopped.
  [[nodiscard]] bool complete(size_t index, const SampleRange& wanted) const;

  bool operator==(const Coverage&) const = default;

 private:
  [[nodiscard]] int columns() const;

  PixelRect area_;
  std::vector<BlockCoverage> blocks_;
};

} // namespace kindling
