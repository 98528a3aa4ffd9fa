// Description of the missing samples of a coverage, by part numbers where possible.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/coverage.h"

#include <cstdint>
#include <string>
#include <vector>

namespace kindling {

// The numbers of parts that the image was divided into; 0 if unknown. Used only to name gaps.
struct PartCounts {
  uint32_t samples = 0;
  uint32_t tiles = 0;
};

struct Gaps {
  // One line per gap: "part 2/3: samples 21-41 of all pixels", "tile part 3/8: all samples of
  // pixels 0,240 to 320,480", "samples 40-63 of pixels ...". Indices are from 0; ranges of samples
  // include both ends, those of pixels are as in --crop. The last line may count further gaps that
  // are not listed.
  std::vector<std::string> lines;
  uint64_t missing_samples = 0; // over all pixels of `crop`
  uint64_t empty_pixels = 0;    // without any sample
  [[nodiscard]] bool none() const { return missing_samples == 0; }
};

// Finds the missing ones of samples [0, samples_per_pixel) of the pixels of `crop`, which must lie
// within coverage.area(). Blocks that adaptive sampling has stopped lack nothing.
[[nodiscard]] Gaps find_gaps(const Coverage& coverage, const PixelRect& crop, uint32_t samples_per_pixel,
                             const PartCounts& counts);

} // namespace kindling
