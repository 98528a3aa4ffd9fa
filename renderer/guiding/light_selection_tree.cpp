// Builds the tree of light selection probabilities from training records.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/light_selection_tree.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace kindling {
namespace {

constexpr size_t kMaxRecords = 256; // of a region
constexpr uint32_t kMaxDepth = 24;
constexpr size_t kTaskRecords = 8192;       // records: regions of this size build their halves in parallel
constexpr double kSurroundingWeight = 32.0; // weight of the surrounding region, in records
constexpr float kMinProbability = 0.05f;    // lower bound, because unseen light may still exist

// The noise of a sample of one kind, selected with probability q, is moment / q: minimal for q
// proportional to its square root.
LightProbabilities probabilities_for(const std::array<double, kLightKinds>& moments) {
  LightProbabilities probabilities{};
  double sum = 0.0;
  for (const double moment : moments) sum += std::sqrt(moment);
  for (size_t f = 0; f < kLightKinds; ++f) {
    const double probability = sum > 0.0 ? std::sqrt(moments[f]) / sum : 1.0 / kLightKinds;
    probabilities[f] = std::max(static_cast<float>(probability), kMinProbability);
  }
  return probabilities;
}

// Sorts by facing, and keeps the order within.
std::array<std::span<LightRecord>, kFacings> sort_by_facing(std::span<LightRecord> records) {
  std::array<size_t, kFacings> counts{}, next{};
  for (const LightRecord& r : records) ++counts[r.facing];
  std::array<std::span<LightRecord>, kFacings> sorted;
  size_t begin = 0;
  for (uint32_t facing = 0; facing < kFacings; ++facing) {
    sorted[facing] = records.subspan(begin, counts[facing]);
    next[facing] = begin;
    begin += counts[facing];
  }
  const std::vector<LightRecord> all(records.begin(), records.end());
  for (const LightRecord& r : all) records[next[r.facing]++] = r;
  return sorted;
}

using Node = RegionNode;

// A tree while it grows.
struct GrowingTree {
  // Grows below `node`. `around` holds the mean moments by kind of the surrounding region.
  void grow(uint32_t node, std::span<LightRecord> records, const LightProbabilities& around, uint32_t depth);
  // Appends another tree (root first), with its root at node `at`.
  void append(const GrowingTree& part, size_t at);

  std::vector<Node> nodes{1};
  std::vector<LightProbabilities> probabilities;
};

void GrowingTree::append(const GrowingTree& part, size_t at) {
  const auto node_offset = static_cast<uint32_t>(nodes.size()) - 1;
  const auto probability_offset = static_cast<uint32_t>(probabilities.size());
  for (size_t i = 0; i < part.nodes.size(); ++i) {
    Node node = part.nodes[i];
    node.next = node.next + (node.axis == RegionNode::kLeaf ? probability_offset : node_offset);
    if (i == 0)
      nodes[at] = node;
    else
      nodes.push_back(node);
  }
  probabilities.insert(probabilities.end(), part.probabilities.begin(), part.probabilities.end());
}

void GrowingTree::grow(uint32_t node, std::span<LightRecord> records, const LightProbabilities& around,
                       uint32_t depth) {
  std::array<double, kLightKinds> moments{};
  V3d sum(0.0), sum2(0.0);
  for (const LightRecord& r : records) {
    moments[static_cast<size_t>(r.kind)] += static_cast<double>(r.moment);
    const V3d p(r.position);
    sum += p;
    sum2 += p * p;
  }
  const auto count = static_cast<double>(records.size());
  LightProbabilities means;
  for (size_t f = 0; f < kLightKinds; ++f) {
    moments[f] = (moments[f] + kSurroundingWeight * static_cast<double>(around[f])) / (count + kSurroundingWeight);
    means[f] = static_cast<float>(moments[f]);
  }
  if (records.size() > kMaxRecords && depth < kMaxDepth) {
    // Splits at the mean along the axis of the largest variance.
    const V3d mean = sum / count;
    const V3d variance = sum2 / count - mean * mean;
    const uint32_t axis = variance.x >= variance.y && variance.x >= variance.z ? 0 : variance.y >= variance.z ? 1 : 2;
    const auto split = static_cast<float>(mean[static_cast<int>(axis)]);
    const auto middle = std::partition(records.begin(), records.end(), [&](const LightRecord& r) {
      return r.position[static_cast<int>(axis)] < split;
    });
    const auto left = static_cast<size_t>(middle - records.begin());
    if (left > 0 && left < records.size()) {
      const auto children = static_cast<uint32_t>(nodes.size());
      nodes.resize(nodes.size() + 2);
      nodes[node].split = split;
      nodes[node].axis = axis;
      nodes[node].next = children;
      if (records.size() < kTaskRecords) {
        grow(children, records.first(left), means, depth + 1);
        grow(children + 1, records.subspan(left), means, depth + 1);
        return;
      }
      std::array<GrowingTree, 2> halves;
      tbb::parallel_invoke([&] { halves[0].grow(0, records.first(left), means, depth + 1); },
                           [&] { halves[1].grow(0, records.subspan(left), means, depth + 1); });
      for (uint32_t i = 0; i < 2; ++i) append(halves[i], children + i);
      return;
    }
  }
  nodes[node].next = static_cast<uint32_t>(probabilities.size());
  probabilities.push_back(probabilities_for(moments));
}

} // namespace

LightSelectionTree::LightSelectionTree(std::span<LightRecord> records) {
  if (records.empty()) return;
  const std::array<std::span<LightRecord>, kFacings> sorted = sort_by_facing(records);
  std::array<double, kLightKinds> moments{};
  for (const LightRecord& r : records)
    moments[static_cast<size_t>(r.kind)] += static_cast<double>(r.moment) / static_cast<double>(records.size());
  LightProbabilities around;
  for (size_t f = 0; f < kLightKinds; ++f) around[f] = static_cast<float>(moments[f]);
  std::array<GrowingTree, kFacings> parts;
  tbb::parallel_for(uint32_t{0}, kFacings, [&](uint32_t facing) { parts[facing].grow(0, sorted[facing], around, 0); });
  GrowingTree all;
  all.nodes.resize(kFacings);
  for (uint32_t facing = 0; facing < kFacings; ++facing) all.append(parts[facing], facing);
  nodes = arrays_.keep(std::move(all.nodes));
  probabilities = arrays_.keep(std::move(all.probabilities));
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
    without += static_cast<double>(records[i].moment / records[i].probability);
    with += static_cast<double>(terms[i]);
  }
  return without > 0.0 ? with / without : 1.0;
}

} // namespace kindling
