// Clear glass in lanes has the bits of layered BSDFs that are such glass and nothing else.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/clear_glass.h"

#include "renderer/bsdf/layered_bsdf.h"
#include "tests/base/same_bits.h"
#include "tests/bsdf/layered_materials.h"
#include "tests/sampling/random.h"

#include <gtest/gtest.h>

#include <vector>

namespace kindling::test {
namespace {

struct Glass {
  BsdfParameters base;
  LayerParameters layers;
  V3f wo;
};

// Any index of refraction, of which some are matched or infinite, seen from any direction; some
// absorbs all light that is not totally reflected.
Glass any_glass(Random& random) {
  Glass glass;
  const uint64_t kind = random.next_u64() % 16;
  glass.base.base_color = kind == 0 ? Rgb(0.0f) : Rgb{random.next_1d(), 1.0f, 1.2f * random.next_1d()};
  glass.base.metallic = 0.0f;
  glass.base.roughness = kStraightRoughness * random.next_1d();
  glass.base.specular = kind <= 1 ? 0.0f : std::min(2.0f * random.next_1d(), 1.0f);
  glass.base.specular_color = Rgb{1.0f, 30.0f * random.next_1d(), random.next_1d()};
  glass.layers.transmission = 1.0f;
  glass.layers.thin_walled = false;
  glass.layers.eta = kind == 2 ? 0.0f : kind == 3 ? 1.0f : 0.4f + 2.0f * random.next_1d();
  glass.layers.reflection_odds = kind < 8 ? 1.0f : 1.0f + 50.0f * random.next_1d();
  glass.layers.diffuse_transmission = kind == 9 ? 0.5f : 0.0f; // of a base that is not there
  glass.wo = random_direction(random);
  glass.wo.z = kind == 4 ? 0.0f : std::abs(glass.wo.z);
  return glass;
}

TEST(ClearGlass, HasTheBitsOfLayersInLanes) {
  Random random(5);
  size_t absorbed = 0, reflected = 0, refracted = 0;
  for (int i = 0; i < 30'000; ++i) {
    std::vector<LayeredBsdf> alone;
    LaneVectors base_color, specular_color, wo;
    LaneNumbers roughness, specular, eta, odds, choice;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const Glass glass = any_glass(random);
      ASSERT_TRUE(is_clear_glass(glass.base, glass.layers));
      alone.emplace_back(glass.base, glass.layers, glass.wo);
      base_color.set(lane, glass.base.base_color), specular_color.set(lane, glass.base.specular_color);
      roughness[lane] = glass.base.roughness, specular[lane] = glass.base.specular;
      eta[lane] = glass.layers.eta, odds[lane] = glass.layers.reflection_odds;
      wo.set(lane, glass.wo), choice[lane] = random.next_1d();
    }
    const BsdfParametersOf<Lanes> parameters{base_color.load(),    0.0f, roughness.load(), 1.5f, specular.load(),
                                             specular_color.load()};
    const ClearGlassOf<Lanes> together(parameters, eta.load(), odds.load(), wo.load());
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
