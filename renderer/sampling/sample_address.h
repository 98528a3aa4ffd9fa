// Address of one sample of one pixel, from which all of its draws are computed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace kindling {

// A sample is point number `index` of the sequence that is scrambled by `key`.
struct SampleAddress {
  uint32_t key = 0;
  uint32_t index = 0;
  uint32_t strata = 0; // jittered sampler: columns + 2^16 rows of its grid; 0 for other samplers
};

} // namespace kindling
