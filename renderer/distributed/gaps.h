// What a coverage lacks, in words: as few as describe it, and by the numbers of the parts where it was divided into such.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/coverage.h"

#include <cstdint>
#include <string>
#include <vector>

namespace kindling {

// How the image was divided, where that is known: 0 otherwise. It only gives gaps their names.
struct PartCounts {
  uint32_t samples = 0;
  uint32_t tiles = 0;
};

struct Gaps {
  // "part 2/3: samples 21-41 of all pixels", "tile part 3/8: all samples of pixels 0,240 to 320,480", "samples 40-63 of pixels ...":
  // indices from 0, ranges of samples with both ends, ranges of pixels as --crop has them. The last line may say how much is not listed.
  std::vector<std::string> lines;
  uint64_t missing_samples = 0; // over all pixels of `crop`
  uint64_t empty_pixels = 0;    // without any sample
  [[nodiscard]] bool none() const { return missing_samples == 0; }
};

// Of samples [0, samples_per_pixel) of the pixels of `crop`, each of which is inside of coverage.area(). Blocks that have stopped lack
// nothing.
[[nodiscard]] Gaps find_gaps(const Coverage& coverage, const PixelRect& crop, uint32_t samples_per_pixel,
                             const PartCounts& counts);

} // namespace kindling
