// The emitter budget: how many emissive triangles are sampled as lights.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

// A lamp that is instanced is stored once, but its triangles are stored as lights once per
// instance: without this limit they would dominate memory.
inline constexpr uint64_t kMaxSampledEmitters = 1ULL << 24;

struct Emitters {
  uint64_t triangles = 0; // emissive ones
  uint64_t instances = 0;
};

struct SampledEmitters {
  std::vector<uint8_t> groups; // by group: 1 if its emitters are sampled; 0 otherwise and for groups without emitters
  uint64_t left_out = 0;       // triangles
};

// Selects the sampled groups. Groups with a single instance are always sampled. Others follow in
// ascending order of their number of triangles over all instances, ties in group order, within the
// budget. BSDF sampling alone finds the omitted ones, which is unbiased.
[[nodiscard]] SampledEmitters choose_sampled_emitters(std::span<const Emitters> groups,
                                                      uint64_t max_triangles = kMaxSampledEmitters);

} // namespace kindling
