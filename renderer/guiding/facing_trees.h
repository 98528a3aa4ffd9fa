// Growing trees over space, one for each facing, that learn a value in each region from records.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/guiding/guide_record.h"
#include "renderer/guiding/position_moments.h"
#include "renderer/guiding/region_node.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace kindling {

// Regions are divided until they have at most kMaxRecords. What `Learned` learns of one follows
// from the mean moments of its records; the region around it, which was divided, counts as
// kSurroundingWeight more records. `Learned` has
//   Record: with a position
//   Value: what a region learns
//   kMoments: their number
//   static uint32_t facing(const Record&);
//   static void add(const Record&, std::array<double, kMoments>&);
//   static Value value(const std::array<double, kMoments>& means);
template <typename Learned>
class FacingTrees {
 public:
  using Record = typename Learned::Record;
  using Value = typename Learned::Value;

  // Sorts `records`, at least one. Deterministic in the records and their order.
  explicit FacingTrees(std::span<Record> records) {
    const std::array<std::span<Record>, kFacings> sorted = sort_by_facing(records);
    Moments moments{};
    for (const Record& record : records) Learned::add(record, moments);
    Means around;
    for (size_t i = 0; i < around.size(); ++i)
      around[i] = static_cast<float>(moments[i] / static_cast<double>(records.size()));
    std::array<Growing, kFacings> parts;
    tbb::parallel_for(uint32_t{0}, kFacings,
                      [&](uint32_t facing) { parts[facing].grow(0, sorted[facing], around, 0); });
    all_.nodes.resize(kFacings);
    for (uint32_t facing = 0; facing < kFacings; ++facing) all_.append(parts[facing], facing);
  }

  [[nodiscard]] std::vector<RegionNode> take_nodes() { return std::move(all_.nodes); } // the roots of all facings first
  [[nodiscard]] std::vector<Value> take_values() { return std::move(all_.values); }

 private:
  using Moments = std::array<double, Learned::kMoments>;
  using Means = std::array<float, Learned::kMoments>;
  static constexpr size_t kMaxRecords = 256;
  static constexpr uint32_t kMaxDepth = 24;
  static constexpr size_t kTaskRecords = 8192; // regions of this size grow their halves in parallel
  static constexpr double kSurroundingWeight = 32.0;

  // Keeps the order of records of one facing.
  static std::array<std::span<Record>, kFacings> sort_by_facing(std::span<Record> records) {
    std::array<size_t, kFacings> counts{}, next{};
    for (const Record& record : records) ++counts[Learned::facing(record)];
    std::array<std::span<Record>, kFacings> sorted;
    size_t begin = 0;
    for (uint32_t facing = 0; facing < kFacings; ++facing) {
      sorted[facing] = records.subspan(begin, counts[facing]);
      next[facing] = begin;
      begin += counts[facing];
    }
    const std::vector<Record> all(records.begin(), records.end());
    for (const Record& record : all) records[next[Learned::facing(record)]++] = record;
    return sorted;
  }

  // A tree while it grows.
  struct Growing {
    // Grows below `node`. `around` has the means of the surrounding region.
    void grow(uint32_t node, std::span<Record> records, const Means& around, uint32_t depth) {
      Moments moments{};
      for (const Record& record : records) Learned::add(record, moments);
      const auto count = static_cast<double>(records.size());
      Means means;
      for (size_t i = 0; i < means.size(); ++i) {
        moments[i] = (moments[i] + kSurroundingWeight * static_cast<double>(around[i])) / (count + kSurroundingWeight);
        means[i] = static_cast<float>(moments[i]);
      }
      if (records.size() > kMaxRecords && depth < kMaxDepth && divide(node, records, means, depth)) return;
      nodes[node].next = static_cast<uint32_t>(values.size());
      values.push_back(Learned::value(moments));
    }

    // Divides the records at their mean along the axis of the largest variance. False: it leaves
    // none on one side.
    bool divide(uint32_t node, std::span<Record> records, const Means& means, uint32_t depth) {
      const PositionMoments positions{std::span<const Record>(records)};
      const V3d& variance = positions.variance;
      const uint32_t axis = variance.x >= variance.y && variance.x >= variance.z ? 0 : variance.y >= variance.z ? 1 : 2;
      const auto split = static_cast<float>(positions.mean[static_cast<int>(axis)]);
      const auto middle = std::partition(records.begin(), records.end(), [&](const Record& record) {
        return record.position[static_cast<int>(axis)] < split;
      });
      const auto left = static_cast<size_t>(middle - records.begin());
      if (left == 0 || left == records.size()) return false;
      const auto children = static_cast<uint32_t>(nodes.size());
      nodes.resize(nodes.size() + 2);
      nodes[node].split = split;
      nodes[node].axis = axis;
      nodes[node].next = children;
      if (records.size() < kTaskRecords) {
        grow(children, records.first(left), means, depth + 1);
        grow(children + 1, records.subspan(left), means, depth + 1);
        return true;
      }
      std::array<Growing, 2> halves;
      tbb::parallel_invoke([&] { halves[0].grow(0, records.first(left), means, depth + 1); },
                           [&] { halves[1].grow(0, records.subspan(left), means, depth + 1); });
      for (uint32_t i = 0; i < 2; ++i) append(halves[i], children + i);
      return true;
    }

    // Appends another tree (root first), with its root at node `at`.
    void append(const Growing& part, size_t at) {
      const auto node_offset = static_cast<uint32_t>(nodes.size()) - 1;
      const auto value_offset = static_cast<uint32_t>(values.size());
      for (size_t i = 0; i < part.nodes.size(); ++i) {
        RegionNode node = part.nodes[i];
        node.next = node.next + (node.axis == RegionNode::kLeaf ? value_offset : node_offset);
        if (i == 0)
          nodes[at] = node;
        else
          nodes.push_back(node);
      }
      values.insert(values.end(), part.values.begin(), part.values.end());
    }

    std::vector<RegionNode> nodes{1};
    std::vector<Value> values;
  };

  Growing all_;
};

} // namespace kindling
