// The stack of media around a path.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/medium_stack.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

constexpr uint32_t kGlass = 3, kWater = 5, kIce = 8;

TEST(MediumStack, LastEnteredMediumIsInnermost) {
  MediumStack media;
  EXPECT_FALSE(media.innermost());
  media.enter(kWater);
  media.enter(kIce);
  EXPECT_EQ(media.innermost(), kIce);
  EXPECT_EQ(media.innermost_without(kIce), kWater);
  EXPECT_TRUE(media.covered(kWater));
  EXPECT_FALSE(media.covered(kIce));
  EXPECT_FALSE(media.covered(kGlass));
  media.leave(kIce);
  EXPECT_EQ(media.innermost(), kWater);
}

// A path goes from glass into a liquid that overlaps it, and back.
TEST(MediumStack, LeavesOverlapsInAnyOrder) {
  MediumStack media;
  media.enter(kGlass);
  media.enter(kWater);
  EXPECT_TRUE(media.covered(kGlass));
  media.leave(kGlass);
  EXPECT_EQ(media.innermost(), kWater);
  media.enter(kGlass);
  EXPECT_TRUE(media.covered(kWater));
  media.leave(kWater);
  media.leave(kGlass);
  EXPECT_TRUE(media.empty());
}

TEST(MediumStack, EqualMaterialsAreCounted) {
  MediumStack media;
  media.enter(kGlass);
  media.enter(kGlass);
  media.leave(kGlass);
  EXPECT_EQ(media.innermost(), kGlass);
  media.leave(kGlass);
  media.leave(kGlass); // was never entered: an open mesh
  EXPECT_TRUE(media.empty());
}

TEST(MediumStack, ForgetsOutermostBeyondCapacity) {
  MediumStack media;
  for (uint32_t i = 0; i <= MediumStack::kMax; ++i) media.enter(i);
  EXPECT_EQ(media.innermost(), MediumStack::kMax);
  for (uint32_t i = static_cast<uint32_t>(MediumStack::kMax); i > 0; --i) media.leave(i);
  EXPECT_TRUE(media.empty());
}

} // namespace
} // namespace kindling
