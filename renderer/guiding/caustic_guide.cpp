// Divides the records of caustics into regions.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/caustic_guide.h"

#include "renderer/guiding/position_moments.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace kindling {
namespace {

constexpr uint32_t kMaxCausticDepth = 32; // of regions
constexpr size_t kMinRegionRecords = 4;   // fewer do not show how far apart they are
// In relation to the longest side of a region: the radius of a lobe at its origin, and how far the
// region reaches beyond its records.
constexpr float kLobeRadius = 0.35f, kMargin = 0.5f;
// A direction counts as found by the guide if it is sampled so many times as often as without.
constexpr float kOftener = 10.0f;

// A tree of regions while it grows.
class GrowingCaustics {
 public:
  explicit GrowingCaustics(float per_path) : per_path_(per_path) {}

  // Divides the records of a node at their mean along the axis of the largest variance where that
  // leaves some on both sides. A median might divide records with equal coordinates, such as those
  // of a floor.
  void grow(uint32_t node, std::span<CausticRecord> records, uint32_t depth) {
    if (records.size() > CausticGuideView::kLobes && depth < kMaxCausticDepth) {
      const PositionMoments moments{std::span<const CausticRecord>(records)};
      const V3d &mean = moments.mean, &variance = moments.variance;
      std::array<int, 3> axes = {0, 1, 2};
      std::stable_sort(axes.begin(), axes.end(), [&](int a, int b) { return variance[a] > variance[b]; });
      for (const int axis : axes)
        if (divide(node, records, axis, static_cast<float>(mean[axis]), depth)) return;
    }
    nodes[node].next = static_cast<uint32_t>(regions.size());
    add_region(records);
  }

  std::vector<RegionNode> nodes{1};
  std::vector<CausticGuideView::Region> regions;

 private:
  // Returns false if one side would have too few records.
  bool divide(uint32_t node, std::span<CausticRecord> records, int axis, float split, uint32_t depth) {
    const auto middle = std::stable_partition(
        records.begin(), records.end(), [&](const CausticRecord& record) { return record.position[axis] < split; });
    const auto left = static_cast<size_t>(middle - records.begin());
    if (left < kMinRegionRecords || records.size() - left < kMinRegionRecords) return false;
    const auto children = static_cast<uint32_t>(nodes.size());
    nodes.resize(nodes.size() + 2);
    nodes[node].split = split;
    nodes[node].axis = static_cast<uint32_t>(axis);
    nodes[node].next = children;
    grow(children, records.first(left), depth + 1);
    grow(children + 1, records.subspan(left), depth + 1);
    return true;
  }

  void add_region(std::span<const CausticRecord> records) {
    Imath::Box3f box;
    for (const CausticRecord& record : records) box.extendBy(record.position);
    CausticGuideView::Region region;
    const V3f size = box.size();
    // Records lie on a surface, whose area is about that of the two longer sides.
    const float longest = std::max({size.x, size.y, size.z}), shortest = std::min({size.x, size.y, size.z});
    const float other = size.x + size.y + size.z - longest - shortest;
    const float area = std::max(longest * other, 0.01f * longest * longest);
    const size_t count = std::min(records.size(), CausticGuideView::kLobes);
    const float scale = area > 0.0f ? static_cast<float>(records.size()) / (static_cast<float>(count) * area) : 0.0f;
    for (size_t j = 0; j < CausticGuideView::kLobes; ++j) {
      const CausticRecord& record = records[std::min(j, count - 1) * records.size() / count];
      region.x[j] = record.origin.x;
      region.y[j] = record.origin.y;
      region.z[j] = record.origin.z;
      region.strength[j] = j < count ? record.power * per_path_ * scale : 0.0f;
    }
    const float margin = kMargin * longest;
    region.low = box.min - V3f(margin);
    region.high = box.max + V3f(margin);
    region.radius2 = square(kLobeRadius * longest);
    regions.push_back(region);
  }

  float per_path_; // what the power of a record is multiplied with
};

} // namespace

CausticGuide::CausticGuide(std::span<CausticRecord> records, uint64_t paths, float other_irradiance) {
  if (records.size() < kLobes) return;
  GrowingCaustics growing(1.0f / static_cast<float>(paths));
  growing.grow(0, records, 0);
  for (const Region& region : growing.regions)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], region.low[axis]);
      high[axis] = std::max(high[axis], region.high[axis]);
    }
  irradiance = other_irradiance;
  nodes = arrays_.keep(std::move(growing.nodes));
  regions = arrays_.keep(std::move(growing.regions));
}

CausticGain caustic_gain(std::span<const GuideRecord> records, uint64_t paths) {
  double share = 0.0, with = 0.0, without = 0.0;
  for (const GuideRecord& record : records) {
    if (record.hit_kind == kOnBounds) continue;
    const auto moment = static_cast<double>(record.contribution2),
               density = static_cast<double>(record.without_caustics);
    if (record.without_caustics * kOftener < 1.0f) share += std::sqrt(moment);
    with += moment;
    without += moment / density;
  }
  if (paths == 0 || !(without > 0.0)) return {};
  return {share / static_cast<double>(paths), with / without};
}

} // namespace kindling
