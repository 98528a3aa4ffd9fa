// Learns how many directions should follow the environment in each region.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/environment_guide.h"

#include "renderer/guiding/facing_trees.h"

#include <algorithm>
#include <array>

namespace kindling {
namespace {

constexpr size_t kShares = 11; // that are tried: 0, and equal steps up to kMaxShare

// Returns the density of a record's direction with a share of directions that follow the
// environment, relative to the one that it was sampled with.
float density(const GuideRecord& record, float share) {
  return record.base + share * (record.environment - record.replaced);
}

struct LearnedShare {
  using Record = GuideRecord;
  using Value = float;
  static constexpr size_t kMoments = kShares;

  static float share(size_t i) {
    return EnvironmentGuideView::kMaxShare * static_cast<float>(i) / static_cast<float>(kShares - 1);
  }
  static uint32_t facing(const GuideRecord& record) { return facing_of(record.normal); }
  // Adds the second moments with each of the shares.
  static void add(const GuideRecord& record, std::array<double, kMoments>& moments) {
    for (size_t i = 0; i < kShares; ++i)
      moments[i] += static_cast<double>(record.contribution2 / density(record, share(i)));
  }
  // The share with the least second moment.
  static float value(const std::array<double, kMoments>& moments) {
    return share(static_cast<size_t>(std::min_element(moments.begin(), moments.end()) - moments.begin()));
  }
};

// A contribution as often as a guide finds it.
struct Expected {
  float squared = 0.0f; // of a record, as it was sampled
  float times = 0.0f;   // that it is expected, while it was recorded once

  [[nodiscard]] float brightness2() const { return squared / (times * times); }
};

// Returns the second moment without the brightest contributions that are expected `rare` times.
double moment_of_frequent(std::vector<Expected>& records, double rare) {
  std::stable_sort(records.begin(), records.end(),
                   [](const Expected& a, const Expected& b) { return a.brightness2() > b.brightness2(); });
  double sum = 0.0;
  for (const Expected& record : records) {
    const auto times = static_cast<double>(record.times);
    const double left_out = std::min(rare, times);
    rare -= left_out;
    sum += (times - left_out) * static_cast<double>(record.brightness2());
  }
  return sum;
}

} // namespace

EnvironmentGuide::EnvironmentGuide(std::span<GuideRecord> records) {
  if (records.empty()) return;
  FacingTrees<LearnedShare> trees(records);
  std::vector<float> learned = trees.take_values();
  region_count_ = learned.size() - static_cast<size_t>(std::count(learned.begin(), learned.end(), 0.0f));
  if (region_count_ == 0) return;
  nodes = arrays_.keep(trees.take_nodes());
  shares = arrays_.keep(std::move(learned));
}

EnvironmentGuide::EnvironmentGuide(float share) : region_count_(1) {
  nodes = arrays_.keep(std::vector<RegionNode>(kFacings));
  shares = arrays_.keep(std::vector<float>{share});
}

double second_moment(std::span<const GuideRecord> records, const EnvironmentGuideView& guide, double rare) {
  std::vector<Expected> with, without;
  for (const GuideRecord& record : records) {
    const float share = guide.empty() ? 0.0f : guide.find(record.position, record.normal);
    with.push_back({record.contribution2, density(record, share)});
    without.push_back({record.contribution2, density(record, 0.0f)});
  }
  const double moment = moment_of_frequent(without, rare);
  return moment > 0.0 ? moment_of_frequent(with, rare) / moment : 1.0;
}

} // namespace kindling
