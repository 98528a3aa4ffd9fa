// Eight BSDFs in lanes have the bits of each alone: set-up, values, densities, samples.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/gltf_bsdf.h"

#include "tests/base/same_bits.h"
#include "tests/bsdf/layered_materials.h"
#include "tests/sampling/random.h"

#include <gtest/gtest.h>

#include <vector>

namespace kindling {
namespace {

using test::lane_of;
using test::Random;
using test::random_direction;
using test::same_bits;

// A direction of any kind, also at and below the horizon.
V3f any_direction(Random& random) {
  V3f w = random_direction(random);
  const float u = random.next_1d();
  if (u < 0.2f) w.z = -w.z;
  return u > 0.9f ? V3f(w.x, w.y, 0.0f).normalized() : w;
}

BsdfParameters any_material(bool lambertian, Random& random) {
  BsdfParameters p = test::random_material(random, 0.0f).base;
  const uint64_t kind = random.next_u64() % 8;
  if (lambertian)
    p.metallic = p.specular = 0.0f;
  else if (kind == 0)
    p.metallic = 1.0f;
  else if (kind == 1)
    p.base_color = Rgb(0.0f);
  else if (kind == 2)
    p.ior = 0.0f;
  if (!lambertian && is_lambertian(p)) p.metallic = 0.5f;
  return p;
}

// Calls compare(lane, eight BSDFs, the one of the lane) for many sets.
template <typename Compare>
void for_many_bsdfs(const Compare& compare) {
  Random random(3);
  for (int i = 0; i < 30'000 && !testing::Test::HasFatalFailure(); ++i) {
    const bool lambertian = i % 5 == 0;
    LaneVectors base_color, specular_color, wo;
    LaneNumbers metallic, roughness, ior, specular;
    std::vector<GltfBsdf> alone;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const BsdfParameters p = any_material(lambertian, random);
      const V3f seen_from = any_direction(random);
      base_color.set(lane, p.base_color), specular_color.set(lane, p.specular_color), wo.set(lane, seen_from);
      metallic[lane] = p.metallic, roughness[lane] = p.roughness, ior[lane] = p.ior, specular[lane] = p.specular;
      alone.emplace_back(p, seen_from);
    }
    const GltfBsdfOf<Lanes> together(
        {base_color.load(), metallic.load(), roughness.load(), ior.load(), specular.load(), specular_color.load()},
        wo.load());
    compare(together, alone, random);
  }
}

void expect_same(const BsdfEvalOf<Lanes>& together, size_t lane, const BsdfEval& alone) {
  ASSERT_TRUE(same_bits(lane_of(together.value, lane), alone.value) && same_bits(together.pdf[lane], alone.pdf) &&
              same_bits(together.reflection_pdf[lane], alone.reflection_pdf));
}

TEST(EightBsdfs, EvaluateToTheBitsOfEach) {
  for_many_bsdfs([](const GltfBsdfOf<Lanes>& together, const std::vector<GltfBsdf>& alone, Random& random) {
    LaneVectors wi;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) wi.set(lane, any_direction(random));
    const BsdfEvalOf<Lanes> eval = together.eval(wi.load());
    const Lanes narrow = together.narrow_density(wi.load(), eval.pdf, 0.1f);
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      expect_same(eval, lane, alone[lane].eval(wi[lane]));
      ASSERT_TRUE(same_bits(narrow[lane], alone[lane].narrow_density(wi[lane], eval.pdf[lane], 0.1f)));
      ASSERT_TRUE(same_bits(lane_of(together.albedo(), lane), alone[lane].albedo()));
      ASSERT_TRUE(same_bits(together.glossy_probability()[lane], alone[lane].glossy_probability()));
      ASSERT_TRUE(same_bits(together.smooth_share(0.1f)[lane], alone[lane].smooth_share(0.1f)));
    }
  });
}

TEST(EightBsdfs, AreSampledToTheBitsOfEach) {
  size_t absorbed = 0;
  for_many_bsdfs([&](const GltfBsdfOf<Lanes>& together, const std::vector<GltfBsdf>& alone, Random& random) {
    LaneNumbers choice, x, y;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane)
      choice[lane] = random.next_1d(), x[lane] = random.next_1d(), y[lane] = random.next_1d();
    const auto drawn = together.draw(choice.load(), {x.load(), y.load()});
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const std::optional<BsdfSample> sample = alone[lane].sample(choice[lane], {x[lane], y[lane]});
      ASSERT_EQ(drawn.found[lane] != 0, sample.has_value());
      absorbed += sample ? 0 : 1;
      if (!sample) continue;
      ASSERT_TRUE(same_bits(lane_of(drawn.wi, lane), sample->wi) &&
                  same_bits(lane_of(drawn.weight, lane), sample->weight));
      ASSERT_TRUE(same_bits(drawn.pdf[lane], sample->pdf) &&
                  same_bits(drawn.reflection_pdf[lane], sample->reflection_pdf));
      ASSERT_EQ(drawn.glossy[lane] != 0, sample->lobe == Lobe::glossy);
    }
    if (!all(together.has_microfacets())) return;
    const auto reflections = together.sample_reflection({x.load(), y.load()});
    for (size_t lane = 0; lane < Lanes::kCount; ++lane)
      ASSERT_TRUE(same_bits(lane_of(reflections, lane), alone[lane].sample_reflection({x[lane], y[lane]})));
  });
  EXPECT_GT(absorbed, 100U);
}

// The BSDF of a lane by itself, with everything that it can do.
TEST(EightBsdfs, CanBeTakenOutOfTheirLanes) {
  for_many_bsdfs([](const GltfBsdfOf<Lanes>& together, const std::vector<GltfBsdf>& alone, Random& random) {
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const GltfBsdf taken = together.lane(lane);
      const V3f wi = any_direction(random);
      const BsdfEval a = taken.eval(wi), b = alone[lane].eval(wi);
      ASSERT_TRUE(same_bits(a.value, b.value) && same_bits(a.pdf, b.pdf));
      ASSERT_TRUE(same_bits(taken.diffuse_value(wi), alone[lane].diffuse_value(wi)));
      ASSERT_TRUE(same_bits(taken.lobe_albedos().diffuse, alone[lane].lobe_albedos().diffuse));
      const float choice = random.next_1d();
      const V2f u = random.next_2d();
      const std::optional<BsdfSample> s = taken.sample(choice, u), t = alone[lane].sample(choice, u);
      ASSERT_EQ(s.has_value(), t.has_value());
      if (!s) continue;
      ASSERT_TRUE(same_bits(s->wi, t->wi) && same_bits(s->weight, t->weight));
    }
  });
}

} // namespace
} // namespace kindling
