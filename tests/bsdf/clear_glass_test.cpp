// Clear glass in lanes has the bits of layered BSDFs that are such glass and nothing else.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/clear_glass.h"

#include "tests/base/same_bits.h"
#include "tests/bsdf/any_glass.h"

#include <gtest/gtest.h>

#include <vector>

namespace kindling::test {
namespace {

// Any index of refraction, of which some are matched or infinite.
AnyGlass any_clear_glass(Random& random) {
  const uint64_t kind = random.next_u64() % 16;
  AnyGlass glass(random, kind);
  glass.base.roughness = kStraightRoughness * random.next_1d();
  glass.layers.eta = kind == 4 ? 0.0f : kind == 5 ? 1.0f : 0.4f + 2.0f * random.next_1d();
  glass.layers.reflection_odds = kind < 8 ? 1.0f : 1.0f + 50.0f * random.next_1d();
  return glass;
}

TEST(ClearGlass, HasTheBitsOfLayersInLanes) {
  Random random(5);
  size_t absorbed = 0, reflected = 0, refracted = 0;
  for (int i = 0; i < 30'000; ++i) {
    std::vector<LayeredBsdf> alone;
    GlassInLanes lanes;
    LaneNumbers choice;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const AnyGlass glass = any_clear_glass(random);
      ASSERT_TRUE(is_clear_glass(glass.base, glass.layers));
      alone.emplace_back(glass.base, glass.layers, glass.wo);
      lanes.set(lane, glass);
      choice[lane] = random.next_1d();
    }
    const ClearGlassOf<Lanes> together(lanes.parameters(), lanes.eta.load(), lanes.odds.load(), lanes.wo.load());
    const ClearSampleOf<Lanes> drawn = together.sample(choice.load());
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const std::optional<BsdfSample> sample = alone[lane].sample(choice[lane], V2f(0.5f));
      const V3f weight = lane_of(drawn.weight, lane);
      if (!sample) {
        ASSERT_TRUE(drawn.found[lane] == 0 || is_black(weight));
        ++absorbed;
        continue;
      }
      ASSERT_TRUE(drawn.found[lane] != 0 && sample->pdf == 0.0f);
      ASSERT_TRUE(same_bits(lane_of(drawn.wi, lane), sample->wi) && same_bits(weight, sample->weight));
      ASSERT_EQ(drawn.reflects[lane] != 0, sample->lobe == Lobe::glossy);
      ++(sample->lobe == Lobe::glossy ? reflected : refracted);
    }
  }
  EXPECT_GT(absorbed, 100U);
  EXPECT_GT(reflected, 1000U);
  EXPECT_GT(refracted, 1000U);
}

// Whatever spreads light, or blocks it, is left to the layered BSDF.
TEST(ClearGlass, IsNothingElse) {
  const BsdfParameters base{.metallic = 0.0f, .roughness = 0.0f};
  LayerParameters layers;
  layers.transmission = 1.0f;
  EXPECT_FALSE(is_clear_glass(base, layers)); // a thin wall
  layers.thin_walled = false;
  EXPECT_TRUE(is_clear_glass(base, layers));
  const auto without = [&](auto BsdfParameters::*member, auto value) {
    BsdfParameters other = base;
    other.*member = value;
    return is_clear_glass(other, layers);
  };
  const auto with = [&](auto LayerParameters::*member, auto value) {
    LayerParameters other = layers;
    other.*member = value;
    return is_clear_glass(base, other);
  };
  EXPECT_FALSE(without(&BsdfParameters::metallic, 0.5f));
  EXPECT_FALSE(without(&BsdfParameters::roughness, 0.04f));
  EXPECT_FALSE(with(&LayerParameters::transmission, 0.9f));
  EXPECT_FALSE(with(&LayerParameters::clearcoat, 0.5f));
  EXPECT_FALSE(with(&LayerParameters::sheen_color, Rgb(0.0f, 0.1f, 0.0f)));
  EXPECT_FALSE(with(&LayerParameters::anisotropy, 0.5f));
}

} // namespace
} // namespace kindling::test
