// Draws of eight vertices at once have the bits of eight single ones.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/bounce_draws.h"
#include "tests/sampling/random.h"

#include <gtest/gtest.h>

#include <vector>

namespace kindling {
namespace {

TEST(LanesSampling, DrawsOfAnyNumberOfVertices) {
  for (const SamplerKind kind :
       {SamplerKind::blue_noise, SamplerKind::sobol, SamplerKind::independent, SamplerKind::jittered}) {
    const Sampler sampler(7, kind, 64);
    test::Random random(4);
    for (size_t count = 0; count <= 40; ++count) {
      for (int repeat = 0; repeat < 100; ++repeat) {
        std::vector<BounceAddress> addresses(count);
        for (BounceAddress& at : addresses) {
          const auto x = static_cast<int>(random.next_u64() % 500), y = static_cast<int>(random.next_u64() % 500);
          at.address = sampler.address({x, y}, static_cast<uint32_t>(random.next_u64() % 64));
          at.dimension = 8 + 8 * static_cast<uint32_t>(random.next_u64() % 20);
        }
        std::vector<BounceDraws> draws(count);
        draw_bounces(addresses, draws);
        for (size_t i = 0; i < count; ++i) {
          const BounceDraws expected = draw_bounce(addresses[i].address, addresses[i].dimension);
          ASSERT_EQ(draws[i].choice, expected.choice) << sampler_name(kind) << ", " << i << " of " << count;
          ASSERT_EQ(draws[i].direction, expected.direction);
          ASSERT_EQ(draws[i].light, expected.light);
          ASSERT_EQ(draws[i].roulette, expected.roulette);
          ASSERT_EQ(draws[i].spare, expected.spare);
        }
      }
    }
  }
}

} // namespace
} // namespace kindling
