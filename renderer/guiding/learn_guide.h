// From the records of training to a guide.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/guiding/guide.h"
#include "renderer/guiding/guide_record.h"

#include <span>
#include <vector>

namespace kindling {

struct LearnedGuide {
  Guide guide;
  // That of what the records brought, had their directions been taken with the guide, relative to that without: of records that
  // the patches were not found by. Below 1 is a gain.
  double second_moment = 1.0;
  double light_second_moment = 1.0; // the same of light samples, by their shares
};

// A function of the records and their order.
[[nodiscard]] LearnedGuide learn_guide(std::span<const GuideRecord> records,
                                       std::span<const LightRecord> light_records);

// The two steps of patches. First, rectangles around those hits of the records that brought most, at most BrightPatches::kMax, with
// strength 1; sorts `records` on the way.
[[nodiscard]] std::vector<BrightPatch> find_patches(std::span<GuideRecord> records);
// Then the strengths that make the second moment least; patches that do next to nothing are dropped.
[[nodiscard]] BrightPatches fit_strengths(std::span<const GuideRecord> records, std::vector<BrightPatch> patches);
// The relative second moment of these records.
[[nodiscard]] double second_moment(std::span<const GuideRecord> records, const BrightPatches& patches);

} // namespace kindling
