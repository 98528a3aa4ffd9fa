// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/share_tree.h"

#include <algorithm>
#include <cmath>

namespace kindling {
namespace {

constexpr size_t kMostRecords = 256; // of a region
constexpr uint32_t kDeepest = 24;
constexpr double kAround = 32.0;     // records that the surroundings count for
constexpr float kLeastShare = 0.05f; // nothing starves: what has not been seen may still be there

// The noise of a sample of one kind, chosen with probability q, is moment / q: least for q in proportion to its root.
LightShares shares_for(const std::array<double, kLightKinds>& moments) {
  LightShares shares{};
  double sum = 0.0;
  for (const double moment : moments) sum += std::sqrt(moment);
  for (size_t f = 0; f < kLightKinds; ++f) {
    const double share = sum > 0.0 ? std::sqrt(moments[f]) / sum : 1.0 / kLightKinds;
    shares[f] = std::max(static_cast<float>(share), kLeastShare);
  }
  return shares;
}

} // namespace

ShareTree::ShareTree(std::span<LightRecord> records) {
  if (records.empty()) return;
  std::stable_sort(records.begin(), records.end(),
                   [](const LightRecord& a, const LightRecord& b) { return a.facing < b.facing; });
  std::array<double, kLightKinds> moments{};
  for (const LightRecord& r : records)
    moments[static_cast<size_t>(r.kind)] += static_cast<double>(r.moment) / static_cast<double>(records.size());
  LightShares around;
  for (size_t f = 0; f < kLightKinds; ++f) around[f] = static_cast<float>(moments[f]);
  nodes_.resize(kFacings);
  size_t begin = 0;
  for (uint32_t facing = 0; facing < kFacings; ++facing) {
    size_t end = begin;
    while (end < records.size() && records[end].facing == facing) ++end;
    build(facing, records.subspan(begin, end - begin), around, 0);
    begin = end;
  }
}

// `around`: mean moments by kind of the surrounding region.
void ShareTree::build(uint32_t node, std::span<LightRecord> records, const LightShares& around, uint32_t depth) {
  std::array<double, kLightKinds> moments{};
  V3d sum(0.0), sum2(0.0);
  for (const LightRecord& r : records) {
    moments[static_cast<size_t>(r.kind)] += static_cast<double>(r.moment);
    const V3d p(r.position);
    sum += p;
    sum2 += p * p;
  }
  const auto count = static_cast<double>(records.size());
  LightShares means;
  for (size_t f = 0; f < kLightKinds; ++f) {
    moments[f] = (moments[f] + kAround * static_cast<double>(around[f])) / (count + kAround);
    means[f] = static_cast<float>(moments[f]);
  }
  if (records.size() > kMostRecords && depth < kDeepest) {
    // At the mean along the axis of the largest variance.
    const V3d mean = sum / count;
    const V3d variance = sum2 / count - mean * mean;
    const uint32_t axis = variance.x >= variance.y && variance.x >= variance.z ? 0 : variance.y >= variance.z ? 1 : 2;
    const auto split = static_cast<float>(mean[static_cast<int>(axis)]);
    const auto middle = std::partition(records.begin(), records.end(), [&](const LightRecord& r) {
      return r.position[static_cast<int>(axis)] < split;
    });
    const auto left = static_cast<size_t>(middle - records.begin());
    if (left > 0 && left < records.size()) {
      const auto children = static_cast<uint32_t>(nodes_.size());
      nodes_.resize(nodes_.size() + 2);
      nodes_[node].split = split;
      nodes_[node].axis = axis;
      nodes_[node].next = children;
      build(children, records.first(left), means, depth + 1);
      build(children + 1, records.subspan(left), means, depth + 1);
      return;
    }
  }
  nodes_[node].next = static_cast<uint32_t>(shares_.size());
  shares_.push_back(shares_for(moments));
}

double second_moment(std::span<const LightRecord> records, const ShareTree& shares) {
  std::array<bool, kLightKinds> seen{};
  for (const LightRecord& r : records) seen[static_cast<size_t>(r.kind)] = true;
  double with = 0.0, without = 0.0;
  for (const LightRecord& r : records) {
    without += static_cast<double>(r.moment / r.probability);
    const LightShares& here = shares.find(r.position, r.facing);
    float sum = 0.0f;
    for (size_t f = 0; f < kLightKinds; ++f) sum += seen[f] ? here[f] : 0.0f;
    with += static_cast<double>(r.moment * sum / here[static_cast<size_t>(r.kind)]);
  }
  return without > 0.0 ? with / without : 1.0;
}

} // namespace kindling
