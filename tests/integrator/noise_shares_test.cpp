// Shares of the noise, from the blocks of a pilot and from what other scenes have.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/noise_shares.h"

#include <gtest/gtest.h>

#include <vector>

namespace kindling::test {
namespace {

// The likely shares without any information.
constexpr double kLights = 0.55, kReflections = 0.19, kAlone = 0.4;

TEST(NoiseShares, BlocksThatAgreeDecideAlone) {
  const std::vector<BlockShares> blocks(100, {2.0, 0.4, 0.3});
  const NoiseShares both = likely_shares(blocks, true, true);
  EXPECT_NEAR(both.lights, 0.2, 1e-12);
  EXPECT_NEAR(both.reflections, 0.15, 1e-12);
}

TEST(NoiseShares, SharesThatAreNotOpenAreZero) {
  const std::vector<BlockShares> blocks(100, {2.0, 0.4, 0.3});
  const NoiseShares lights = likely_shares(blocks, true, false), reflections = likely_shares(blocks, false, true);
  EXPECT_NEAR(lights.lights, 0.2, 1e-12);
  EXPECT_EQ(lights.reflections, 0.0);
  EXPECT_EQ(reflections.lights, 0.0);
  EXPECT_NEAR(reflections.reflections, 0.15, 1e-12);
}

// One block has nearly all noise, and suggests that light samples add to it. The others have .5 and
// .2.
TEST(NoiseShares, ASingleBlockDoesNotDecide) {
  std::vector<BlockShares> blocks(100, {1.0, 0.5, 0.2});
  blocks[17] = {5000.0, -40000.0, 10000.0};
  const NoiseShares both = likely_shares(blocks, true, true);
  EXPECT_NEAR(both.lights, kLights, 0.06);
  EXPECT_NEAR(both.reflections, kReflections, 0.02);
  EXPECT_NEAR(likely_shares(blocks, true, false).lights, kAlone, 0.05);
  EXPECT_NEAR(likely_shares(blocks, false, true).reflections, kAlone, 0.1);
}

// Half of the blocks have nothing, half twice the share. Without one of them the share differs by
// itself over the number of the others.
TEST(NoiseShares, AreWeightedByTheirVariances) {
  constexpr double kShare = 0.95, kPrior = 0.3 * 0.3;
  constexpr int kCount = 10;
  std::vector<BlockShares> blocks;
  for (int i = 0; i < kCount; ++i) blocks.push_back({1.0, i % 2 == 0 ? 0.0 : 2.0 * kShare, 0.0});
  const double variance = kCount * kShare * kShare / ((kCount - 1) * (kCount - 1));
  EXPECT_NEAR(likely_shares(blocks, true, false).lights, (kShare * kPrior + kAlone * variance) / (kPrior + variance),
              1e-12);
}

// Blocks that differ in which samples they need, but not in the sum, leave the sum as it is.
TEST(NoiseShares, CertainSumsStay) {
  std::vector<BlockShares> blocks;
  for (int i = 0; i < 20; ++i) blocks.push_back(i % 2 == 0 ? BlockShares{1.0, 0.95, 0.0} : BlockShares{1.0, 0.0, 0.95});
  const NoiseShares both = likely_shares(blocks, true, true);
  EXPECT_NEAR(both.lights + both.reflections, 0.95, 1e-9);
  EXPECT_GT(both.lights, 0.5); // measured: .475 each
}

TEST(NoiseShares, NeverExceedAllNoise) {
  const NoiseShares both = likely_shares(std::vector<BlockShares>(100, {1.0, 0.97, 0.09}), true, true);
  EXPECT_NEAR(both.lights, 0.91, 1e-9);
  EXPECT_NEAR(both.reflections, 0.09, 1e-9);
  const NoiseShares none = likely_shares(std::vector<BlockShares>(100, {1.0, -0.2, -0.1}), true, true);
  EXPECT_EQ(none.lights, 0.0);
  EXPECT_EQ(none.reflections, 0.0);
}

} // namespace
} // namespace kindling::test
