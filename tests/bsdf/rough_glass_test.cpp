// Rough glass in lanes has the bits of layered BSDFs that are such glass and nothing else.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/rough_glass.h"

#include "tests/base/same_bits.h"
#include "tests/bsdf/any_glass.h"

#include <gtest/gtest.h>

#include <vector>

namespace kindling::test {
namespace {

// Any index of refraction that is not matched, of which some are infinite.
AnyGlass any_rough_glass(Random& random) {
  const uint64_t kind = random.next_u64() % 16;
  AnyGlass glass(random, kind);
  glass.base.roughness = kind == 4 ? 1.5f : std::max(random.next_1d(), 1.001f * kStraightRoughness);
  const float index = 1.02f + 1.5f * random.next_1d();
  glass.layers.eta = kind == 5 ? 0.0f : kind < 10 ? index : 1.0f / index;
  return glass;
}

// Eight of them, one by one and in lanes.
struct Together {
  std::vector<LayeredBsdf> alone;
  std::vector<RoughGlassOf<Lanes>> lanes; // one

  explicit Together(Random& random) {
    GlassInLanes together;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const AnyGlass glass = any_rough_glass(random);
      EXPECT_TRUE(is_rough_glass(glass.base, glass.layers) && !is_matched(valid_eta(glass.layers.eta)));
      alone.emplace_back(glass.base, glass.layers, glass.wo);
      together.set(lane, glass);
    }
    lanes.emplace_back(together.parameters(), together.eta.load(), together.wo.load());
  }
};

TEST(RoughGlass, HasTheValuesOfLayersInLanes) {
  Random random(7);
  size_t black = 0, reflected = 0, refracted = 0;
  for (int i = 0; i < 30'000; ++i) {
    const Together glass(random);
    LaneVectors directions;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      V3f wi = random_direction(random);
      wi.z = i % 16 == 0 ? 0.0f : i % 2 == 0 ? wi.z : -wi.z;
      directions.set(lane, wi);
    }
    const RoughGlassOf<Lanes>::Eval eval = glass.lanes[0].eval(directions.load());
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const BsdfEval expected = glass.alone[lane].eval(directions[lane]);
      ASSERT_TRUE(same_bits(lane_of(eval.value, lane), expected.value));
      ASSERT_EQ(eval.pdf[lane], expected.pdf);
      ASSERT_EQ(expected.reflection_pdf, 0.0f);
      ++(is_black(expected.value) ? black : directions[lane].z > 0.0f ? reflected : refracted);
    }
  }
  EXPECT_GT(black, 1000U);
  EXPECT_GT(reflected, 1000U);
  EXPECT_GT(refracted, 1000U);
}

TEST(RoughGlass, HasTheSamplesOfLayersInLanes) {
  Random random(8);
  size_t absorbed = 0, reflected = 0, refracted = 0;
  for (int i = 0; i < 30'000; ++i) {
    const Together glass(random);
    LaneNumbers choice, x, y;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane)
      choice[lane] = random.next_1d(), x[lane] = random.next_1d(), y[lane] = random.next_1d();
    const auto drawn = glass.lanes[0].sample(choice.load(), {x.load(), y.load()});
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const std::optional<BsdfSample> sample = glass.alone[lane].sample(choice[lane], V2f(x[lane], y[lane]));
      ASSERT_EQ(drawn.found[lane] != 0, sample.has_value());
      if (!sample) {
        ++absorbed;
        continue;
      }
      ASSERT_TRUE(same_bits(lane_of(drawn.wi, lane), sample->wi));
      ASSERT_TRUE(same_bits(lane_of(drawn.weight, lane), sample->weight));
      ASSERT_EQ(drawn.pdf[lane], sample->pdf);
      ASSERT_EQ(drawn.reflects[lane] != 0, sample->lobe == Lobe::glossy);
      ++(sample->lobe == Lobe::glossy ? reflected : refracted);
    }
  }
  EXPECT_GT(absorbed, 1000U);
  EXPECT_GT(reflected, 1000U);
  EXPECT_GT(refracted, 1000U);
}

// Smooth glass, thin walls, and whatever lies on glass are left to the layered BSDF.
TEST(RoughGlass, IsNothingElse) {
  BsdfParameters base{.metallic = 0.0f, .roughness = 0.2f};
  LayerParameters layers;
  layers.transmission = 1.0f;
  EXPECT_FALSE(is_rough_glass(base, layers)); // a thin wall
  layers.thin_walled = false;
  EXPECT_TRUE(is_rough_glass(base, layers));
  base.roughness = kStraightRoughness;
  EXPECT_FALSE(is_rough_glass(base, layers));
  base.roughness = 0.2f;
  layers.clearcoat = 0.5f;
  EXPECT_FALSE(is_rough_glass(base, layers));
}

TEST(DielectricAlbedo, HasTheSameBitsInLanes) {
  Random random(9);
  for (int i = 0; i < 20'000; ++i) {
    LaneNumbers mu, roughness, eta;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      mu[lane] = std::max(random.next_1d(), 1e-4f);
      roughness[lane] = random.next_1d();
      eta[lane] = lane == 0 ? 1e4f : lane == 1 ? 1e-4f : 0.3f + 3.0f * random.next_1d();
    }
    const Lanes alpha = roughness.load() * roughness.load();
    const auto together = dielectric_albedo(mu.load(), roughness.load(), alpha, eta.load());
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const DielectricAlbedo alone = dielectric_albedo(mu[lane], roughness[lane], alpha[lane], eta[lane]);
      ASSERT_TRUE(same_bits(V3f(together.e[lane], together.p[lane], together.q[lane]), V3f(alone.e, alone.p, alone.q)));
      ASSERT_EQ(together.reflected[lane], alone.reflected);
    }
  }
}

} // namespace
} // namespace kindling::test
