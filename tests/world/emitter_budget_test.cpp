// Tests of the selection of emitters within the budget.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/emitter_budget.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

TEST(EmitterBudget, PrefersSmallGroups) {
  const std::vector<Emitters> groups{{10, 100}, {0, 5}, {2, 50}, {1, 400}, {3, 20}};
  const SampledEmitters all = choose_sampled_emitters(groups, 1560);
  EXPECT_EQ(all.groups, (std::vector<uint8_t>{1, 0, 1, 1, 1}));
  EXPECT_EQ(all.left_out, 0U);
  const SampledEmitters some = choose_sampled_emitters(groups, 1559);
  EXPECT_EQ(some.groups, (std::vector<uint8_t>{0, 0, 1, 1, 1}));
  EXPECT_EQ(some.left_out, 1000U);
  const SampledEmitters few = choose_sampled_emitters(groups, 200);
  EXPECT_EQ(few.groups, (std::vector<uint8_t>{0, 0, 1, 0, 1}));
  EXPECT_EQ(few.left_out, 1400U);
}

TEST(EmitterBudget, SingleInstancesAreAlwaysSampled) {
  const std::vector<Emitters> groups{{5000, 1}, {7, 10}};
  const SampledEmitters sampled = choose_sampled_emitters(groups, 100);
  EXPECT_EQ(sampled.groups, (std::vector<uint8_t>{1, 0}));
  EXPECT_EQ(sampled.left_out, 70U);
}

} // namespace
} // namespace kindling
