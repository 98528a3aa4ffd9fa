// Random numbers of many path vertices.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/bounce_draws.h"

#include "renderer/base/lanes.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace kindling {
namespace {

// Returns the draws of eight vertices from their keys, indices and dimensions: a row for each, in
// the order of the members of BounceDraws.
LaneRows draw_lanes(const Words8& key, const Words8& address_index, const Words8& dimension) {
  using namespace owen_sobol;
  Lanes draws[Lanes::kCount];
  const Words8 reversed = reverse_bits(address_index);
  const Words8 mixed_key = 0x9e3779b9U + (key << 6) + (key >> 2); // of hash_combine()
  for (uint32_t set = 0; set < 2; ++set) {
    const Words8 seed = hash_words(key ^ (dimension + set + mixed_key));
    const Words8 index = reverse_bits(scramble_reversed(reversed, seed));
    const Words8 second = second_pair_index(index);
    const std::array<Words8, 4> points{index, second_reversed(index), second, second_reversed(second)};
    for (size_t i = 0; i < points.size(); ++i) {
      const Words8 bits = reverse_bits(scramble_reversed(points[i], hash_words(seed ^ Sampler::kCoordinateSeeds[i])));
      draws[set * 4 + i] = Lanes(__builtin_convertvector((Int8)(bits >> 8), Float8) * 0x1p-24f);
    }
  }
  LaneRows result;
  result.store_columns(draws);
  return result;
}

} // namespace

void draw_bounces(std::span<const BounceAddress> addresses, std::span<BounceDraws> draws) {
  assert(addresses.size() == draws.size());
  const bool stratified = !addresses.empty() && addresses[0].address.strata != 0;
  for (size_t first = 0; first < addresses.size(); first += Lanes::kCount) {
    const size_t count = std::min(Lanes::kCount, addresses.size() - first);
    if (stratified || count < 3) { // fewer are drawn faster one by one
      for (size_t i = first; i < first + count; ++i)
        draws[i] = draw_bounce(addresses[i].address, addresses[i].dimension);
      continue;
    }
    Words8 key, index, dimension;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const BounceAddress& at = addresses[first + std::min(lane, count - 1)];
      key[lane] = at.address.key, index[lane] = at.address.index, dimension[lane] = at.dimension;
    }
    const LaneRows rows = draw_lanes(key, index, dimension);
    for (size_t lane = 0; lane < count; ++lane) {
      const float* const u = rows[lane];
      draws[first + lane] = {{u[0], u[1]}, {u[2], u[3]}, {u[4], u[5]}, u[6], u[7]};
    }
  }
}

} // namespace kindling
