// Learns a guide from training records.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/guiding/guide.h"
#include "renderer/guiding/guide_record.h"

#include <span>
#include <vector>

namespace kindling {

struct LearnedGuide {
  Guide guide;
  // Second moment of the records' contributions with the guide, relative to that without, on
  // records that were not used to find the patches. Below 1 is a gain.
  double second_moment = 1.0;
  double light_second_moment = 1.0; // likewise for light samples
};

// Deterministic in the records and their order.
[[nodiscard]] LearnedGuide learn_guide(std::span<const GuideRecord> records,
                                       std::span<const LightRecord> light_records);

// The two steps for patches. First, finds rectangles around the hits of the records with the
// largest contributions, at most BrightPatches::kMax, with strength 1; sorts `records`.
[[nodiscard]] std::vector<BrightPatch> find_patches(std::span<GuideRecord> records);
// Then fits the strengths that minimize the second moment; patches of negligible effect are
// dropped.
[[nodiscard]] BrightPatches fit_strengths(std::span<const GuideRecord> records, std::vector<BrightPatch> patches);
// Returns the relative second moment of these records.
[[nodiscard]] double second_moment(std::span<const GuideRecord> records, const BrightPatches& patches);

} // namespace kindling
