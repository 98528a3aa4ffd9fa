// How many emissive triangles are sampled as lights.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

// A lamp that is instanced is held once, its triangles as lights once for each instance: beyond these, memory would be theirs alone.
inline constexpr uint64_t kMaxSampledEmitters = 1ULL << 24;

struct Emitters {
  uint64_t triangles = 0; // emissive ones
  uint64_t instances = 0;
};

struct SampledEmitters {
  std::vector<uint8_t> groups; // by group: 1 if its emitters are sampled; 0 for those that have none, too
  uint64_t left_out = 0;       // triangles
};

// By group. What stands once is always sampled; then groups with fewer triangles in all instances come first, of equal ones the earlier.
// What is left out is found by BSDF sampling alone, which is unbiased.
[[nodiscard]] SampledEmitters choose_sampled_emitters(std::span<const Emitters> groups,
                                                      uint64_t most = kMaxSampledEmitters);

} // namespace kindling
