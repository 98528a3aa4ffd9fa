// Learns patches and light selection probabilities from training records.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/learn_guide.h"

#include "renderer/base/hash.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>

namespace kindling {
namespace {

constexpr double kMaxFraction = 0.002;     // of the sum of all moments: larger contributions count as outliers
constexpr double kTargetRecords = 24000.0; // records: the fit evaluates each of them for each patch, many times
constexpr size_t kMinRecords = 256;        // with fewer records nothing is learned
constexpr std::array kSearches{PatchSearch{PatchSearch::Splits::cost, 0.6},
                               PatchSearch{PatchSearch::Splits::cost, 0.35},
                               PatchSearch{PatchSearch::Splits::spread, 0.6}};

// Returns a smaller, representative set: records with large moments are kept, others are subsampled
// with larger moments.
std::vector<GuideRecord> select(std::span<const GuideRecord> records) {
  double sum = 0.0;
  for (const GuideRecord& r : records) sum += static_cast<double>(r.contribution2);
  const auto largest = static_cast<float>(sum * kMaxFraction);
  double capped_sum = 0.0;
  for (const GuideRecord& r : records) capped_sum += static_cast<double>(std::min(r.contribution2, largest));
  const auto remaining_moment = static_cast<float>(capped_sum / kTargetRecords);
  std::vector<GuideRecord> selected;
  for (size_t i = 0; i < records.size(); ++i) {
    GuideRecord record = records[i];
    record.contribution2 = std::min(record.contribution2, largest);
    if (record.contribution2 < remaining_moment) {
      const float u = to_unit_float(hash_u32(static_cast<uint32_t>(i) ^ 0x3c6ef372U));
      if (u * remaining_moment >= record.contribution2) continue;
      record.contribution2 = remaining_moment;
    }
    selected.push_back(record);
  }
  return selected;
}

// Records that find patches, and others that these are fitted to, to avoid overfitting.
using Halves = std::array<std::vector<GuideRecord>, 2>;

// Returns empty halves if there are too few records.
Halves divide(std::span<const GuideRecord> records) {
  const std::vector<GuideRecord> selected = select(records);
  Halves halves;
  if (selected.size() < kMinRecords) return halves;
  for (size_t i = 0; i < selected.size(); ++i) halves[i % 2].push_back(selected[i]);
  return halves;
}

struct FittedPatches {
  BrightPatches patches;
  double second_moment = 1.0;
};

// Returns the best of the sets of patches that several searches find. No search is best for every
// scene.
FittedPatches best_patches(const Halves& halves) {
  std::array<FittedPatches, kSearches.size()> sets;
  tbb::parallel_for(size_t{0}, sets.size(), [&](size_t i) {
    std::vector<GuideRecord> records = halves[0];
    sets[i].patches = fit_strengths(halves[1], find_patches(records, kSearches[i]));
    sets[i].second_moment = second_moment(halves[1], sets[i].patches);
  });
  return *std::min_element(sets.begin(), sets.end(), [](const FittedPatches& a, const FittedPatches& b) {
    return a.second_moment < b.second_moment;
  });
}

void learn_patches(std::span<const GuideRecord> records, LearnedGuide& learned) {
  std::vector<GuideRecord> on_surfaces;
  for (const GuideRecord& record : records)
    if (record.hit_kind == kOnSurface) on_surfaces.push_back(record);
  Halves halves = divide(on_surfaces);
  if (halves[0].empty()) return;
  const FittedPatches best = best_patches(halves);
  learned.guide.patches = best.patches;
  learned.second_moment = best.second_moment;
}

// Returns the records that patches of openings were fitted to; empty if there are none.
std::vector<GuideRecord> learn_openings(std::span<const GuideRecord> records, LearnedGuide& learned) {
  Halves halves = divide(records);
  const bool has_openings = move_to_openings(halves[0]);
  const bool leaves_scene = std::any_of(halves[0].begin(), halves[0].end(),
                                        [](const GuideRecord& record) { return record.hit_kind == kOnBounds; });
  if (!has_openings && !leaves_scene) return {};
  const FittedPatches best = best_patches(halves);
  learned.patches_of_openings = best.patches;
  learned.second_moment_of_openings = best.second_moment;
  return halves[1];
}

void learn_light_probabilities(std::span<const LightRecord> records, LearnedGuide& learned) {
  if (records.size() < kMinRecords) return;
  double sum = 0.0;
  for (const LightRecord& r : records) sum += static_cast<double>(r.moment);
  const auto largest = static_cast<float>(sum * kMaxFraction);
  std::vector<LightRecord> all(records.begin(), records.end()), halves[2];
  for (size_t i = 0; i < all.size(); ++i) {
    all[i].moment = std::min(all[i].moment, largest);
    halves[i % 2].push_back(all[i]);
  }
  tbb::parallel_invoke([&] { learned.light_second_moment = second_moment(halves[1], LightSelectionTree(halves[0])); },
                       [&] { learned.guide.light_probabilities = LightSelectionTree(all); });
}

} // namespace

LearnedGuide learn_guide(std::span<const GuideRecord> records, std::span<const LightRecord> light_records,
                         const GuideParts& parts) {
  LearnedGuide learned;
  std::vector<GuideRecord> fitted;
  tbb::parallel_invoke(
      [&] {
        if (parts.patches) learn_patches(records, learned);
      },
      [&] {
        if (parts.openings) fitted = learn_openings(records, learned);
      },
      [&] {
        if (parts.lights) learn_light_probabilities(light_records, learned);
      });
  if (!(learned.second_moment_of_openings < second_moment(fitted, learned.guide.patches)))
    learned.second_moment_of_openings = kInfinity;
  return learned;
}

// Each half of the records judges what the other one has learned; then all learn.
LearnedEnvironment learn_environment(std::span<const GuideRecord> records, double rare) {
  std::array<std::vector<GuideRecord>, 2> halves, learning;
  for (size_t i = 0; i < records.size(); ++i) halves[i % 2].push_back(records[i]);
  for (size_t h = 0; h < halves.size(); ++h) {
    learning[h] = select(halves[h]);
    if (learning[h].size() < kMinRecords) return {};
  }
  LearnedEnvironment learned{.second_moment = 0.0};
  for (size_t h = 0; h < halves.size(); ++h)
    learned.second_moment += 0.5 * second_moment(halves[1 - h], EnvironmentGuide(learning[h]), 0.5 * rare);
  std::vector<GuideRecord> all = select(records);
  learned.guide = EnvironmentGuide(all);
  return learned;
}

} // namespace kindling
