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
  // Second moment of the contributions of the records that hit surfaces with the guide, relative to
  // that without, on records that were not used to find the patches. Below 1 is a gain.
  double second_moment = 1.0;
  double light_second_moment = 1.0; // likewise for light samples
  // Patches to use instead of the guide's: they are learned from all records, and also aim at light
  // that comes through openings or from beyond the scene. Their second moment is that of all
  // records; it is infinite if the guide's patches are as good.
  BrightPatches patches_of_openings;
  double second_moment_of_openings = kInfinity;
};

struct GuideParts {
  bool patches = true, openings = true, lights = true;
};

// Learns these parts of a guide, of which none are the environment's directions. Deterministic in
// the records and their order.
[[nodiscard]] LearnedGuide learn_guide(std::span<const GuideRecord> records, std::span<const LightRecord> light_records,
                                       const GuideParts& parts = {});

struct LearnedEnvironment {
  EnvironmentGuide guide;
  double second_moment = 1.0; // of all records, as above
};
// Light that is found `rare` times among the paths of these records is so rare that few pixels show
// it: second_moment() of environment_guide.h. Deterministic in the records and their order.
[[nodiscard]] LearnedEnvironment learn_environment(std::span<const GuideRecord> records, double rare);

// The steps for patches. First, hits of light that comes through an opening, such as a window or a
// door, are moved to a rectangle there if they are less spread in it. At most one opening is found
// across each axis, seen from each side. False: no hit was moved.
[[nodiscard]] bool move_to_openings(std::span<GuideRecord> records);
// A search for patches. Hits are split where that lowers either the predicted second moment, which
// finds bright places where hits are dense already, or the sum of sqrt(area * moment), which finds
// them in wide and dim surroundings, too.
struct PatchSearch {
  enum class Splits : uint8_t { cost, spread } splits = Splits::cost;
  // The second moment to expect with the patches, relative to that without, above 0: the lower, the
  // smaller they are.
  double expected_moment = 0.6;
};
// Then finds rectangles around the hits of the records with the largest contributions, at most
// BrightPatches::kMax, with strength 1; sorts `records`.
[[nodiscard]] std::vector<BrightPatch> find_patches(std::span<GuideRecord> records, const PatchSearch& search);
// Last fits the strengths that minimize the second moment; patches of negligible effect are
// dropped.
[[nodiscard]] BrightPatches fit_strengths(std::span<const GuideRecord> records, std::vector<BrightPatch> patches);
// Returns the relative second moment of these records.
[[nodiscard]] double second_moment(std::span<const GuideRecord> records, const BrightPatches& patches);

} // namespace kindling
