// Mean and variance of the positions of records, which trees over space are divided by.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <span>

namespace kindling {

struct PositionMoments {
  V3d mean{0.0};
  V3d variance{0.0}; // by axis

  // `records` have a position each; at least one.
  template <typename Record>
  explicit PositionMoments(std::span<const Record> records) {
    V3d sum2(0.0);
    for (const Record& record : records) {
      const V3d p(record.position);
      mean += p;
      sum2 += p * p;
    }
    const auto count = static_cast<double>(records.size());
    mean /= count;
    variance = sum2 / count - mean * mean;
  }
};

} // namespace kindling
