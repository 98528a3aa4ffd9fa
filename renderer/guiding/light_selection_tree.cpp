// Builds the tree of light selection probabilities from training records.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/light_selection_tree.h"

#include "renderer/guiding/facing_trees.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace kindling {
namespace {

constexpr float kMinProbability = 0.05f; // lower bound, because unseen light may still exist

struct LearnedProbabilities {
  using Record = LightRecord;
  using Value = LightProbabilities;
  static constexpr size_t kMoments = kLightKinds;

  static uint32_t facing(const LightRecord& record) { return record.facing; }
  static void add(const LightRecord& record, std::array<double, kMoments>& moments) {
    moments[static_cast<size_t>(record.kind)] += static_cast<double>(record.moment);
  }
  // The noise of a sample of one kind, selected with probability q, is moment / q: minimal for q
  // proportional to its square root.
  static LightProbabilities value(const std::array<double, kMoments>& moments) {
    LightProbabilities probabilities{};
    double sum = 0.0;
    for (const double moment : moments) sum += std::sqrt(moment);
    for (size_t f = 0; f < kLightKinds; ++f) {
      const double probability = sum > 0.0 ? std::sqrt(moments[f]) / sum : 1.0 / kLightKinds;
      probabilities[f] = std::max(static_cast<float>(probability), kMinProbability);
    }
    return probabilities;
  }
};

} // namespace

LightSelectionTree::LightSelectionTree(const LightProbabilities& everywhere) {
  nodes = arrays_.keep(std::vector<RegionNode>(kFacings));
  probabilities = arrays_.keep(std::vector<LightProbabilities>{everywhere});
}

LightSelectionTree::LightSelectionTree(std::span<LightRecord> records) {
  if (records.empty()) return;
  FacingTrees<LearnedProbabilities> trees(records);
  nodes = arrays_.keep(trees.take_nodes());
  probabilities = arrays_.keep(trees.take_values());
}

double second_moment(std::span<const LightRecord> records, const LightSelectionTreeView& tree) {
  std::array<bool, kLightKinds> seen{};
  for (const LightRecord& r : records) seen[static_cast<size_t>(r.kind)] = true;
  std::vector<float> terms(records.size());
  tbb::parallel_for(tbb::blocked_range<size_t>(0, records.size(), 4096), [&](const auto& range) {
    for (size_t i = range.begin(); i != range.end(); ++i) {
      const LightRecord& r = records[i];
      const LightProbabilities& here = tree.find(r.position, r.facing);
      float sum = 0.0f;
      for (size_t f = 0; f < kLightKinds; ++f) sum += seen[f] ? here[f] : 0.0f;
      terms[i] = r.moment * sum / here[static_cast<size_t>(r.kind)];
    }
  });
  double with = 0.0, without = 0.0; // summed in order
  for (size_t i = 0; i < records.size(); ++i) {
    without += static_cast<double>(records[i].moment / records[i].unguided_probability);
    with += static_cast<double>(terms[i]);
  }
  return without > 0.0 ? with / without : 1.0;
}

} // namespace kindling
