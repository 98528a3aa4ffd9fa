// The name of one sample of one pixel, by which its draws are found.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace kindling {

// Where the points of one sample of one pixel are found: `index` counts in the sequence that `key` scrambles.
struct SampleAddress {
  uint32_t key = 0;
  uint32_t index = 0;
  uint32_t strata = 0; // of the jittered sampler alone: columns + 2^16 rows of its cells; else 0
};

} // namespace kindling
