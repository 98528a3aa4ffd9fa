// Groups of items by an integer key, built in parallel: for example the corners at each vertex.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/uninitialized_vector.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace kindling {

// Calls f(begin, end) in parallel (TBB) for ranges that partition [0, count).
template <typename F>
void for_index_ranges(size_t count, const F& f) {
  tbb::parallel_for(tbb::blocked_range<size_t>(0, count, size_t{1} << 12),
                    [&](const tbb::blocked_range<size_t>& range) { f(range.begin(), range.end()); });
}

// Groups the items 0 to item_count - 1 (fewer than 2^32) by their keys, which are below key_count.
// Each item is stored as a Value, which must be ordered; groups are sorted, so the result does not
// depend on the order of threads.
template <typename Value>
class IndexGroups {
 public:
  static constexpr uint32_t kLeftOut = 0xffffffffU; // key of items that are in no group

  template <typename KeyOf, typename ValueOf>
  IndexGroups(uint32_t item_count, size_t key_count, const KeyOf& key_of, const ValueOf& value_of)
      : begin_(key_count + 1, 0), shared_(tbb::this_task_arena::max_concurrency() > 1) {
    const auto for_items = [&](const auto& visit) {
      for_index_ranges(item_count, [&](size_t begin, size_t end) {
        for (auto item = static_cast<uint32_t>(begin); item < end; ++item)
          if (const uint32_t key = key_of(item); key != kLeftOut) visit(item, key);
      });
    };
    for_items([&](uint32_t /*item*/, uint32_t key) { next(key); });
    // begin_[key + 1] starts as the beginning of the group; filling advances it to the group's end,
    // which is where the next group begins.
    uint32_t sum = 0;
    for (size_t key = 0; key < key_count; ++key) sum += std::exchange(begin_[key + 1], sum);
    values_.resize(sum);
    for_items([&](uint32_t item, uint32_t key) { values_[next(key)] = value_of(item); });
    for_index_ranges(key_count, [&](size_t begin, size_t end) {
      for (size_t key = begin; key < end; ++key) {
        Value* const first = values_.data() + begin_[key];
        Value* const last = values_.data() + begin_[key + 1];
        if (!std::is_sorted(first, last)) std::sort(first, last);
      }
    });
  }

  [[nodiscard]] size_t key_count() const { return begin_.size() - 1; }
  [[nodiscard]] std::span<const Value> operator[](size_t key) const {
    return {values_.data() + begin_[key], values_.data() + begin_[key + 1]};
  }

 private:
  uint32_t next(uint32_t key) {
    uint32_t& entry = begin_[key + 1];
    return shared_ ? std::atomic_ref<uint32_t>(entry).fetch_add(1, std::memory_order_relaxed) : entry++;
  }

  std::vector<uint32_t> begin_;
  bool shared_; // filled by several threads
  UninitializedVector<Value> values_;
};

} // namespace kindling
