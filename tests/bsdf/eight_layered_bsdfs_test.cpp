// Eight layered BSDFs in lanes have the bits of each alone: set-up, values, densities, samples.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/layered_bsdf.h"

#include "tests/base/same_bits.h"
#include "tests/bsdf/layered_materials.h"
#include "tests/sampling/random.h"

#include <gtest/gtest.h>

#include <vector>

namespace kindling {
namespace {

using test::LayeredMaterial;
using test::Random;
using test::same_bits;

// A direction of any kind, also at and below the horizon.
V3f any_direction_of_layers(Random& random) {
  V3f w = test::random_direction(random);
  const float u = random.next_1d();
  if (u < 0.2f) w.z = -w.z;
  return u > 0.9f ? V3f(w.x, w.y, 0.0f).normalized() : w;
}

// An opaque material with any of coat, sheen and anisotropy. A few have values that are not valid.
LayeredMaterial any_opaque_layers(bool lambertian, Random& random) {
  LayeredMaterial m = test::random_material(random, 0.0f);
  LayerParameters& l = m.layers;
  l.transmission = l.diffuse_transmission = l.iridescence = 0.0f;
  const uint64_t without = random.next_u64();
  if (without & 1) l.clearcoat = 0.0f;
  if (without & 2) l.sheen_color = Rgb(0.0f);
  if (without & 4) l.anisotropy = 0.0f;
  if ((without & 0x38) == 0) m.base.base_color = Rgb(0.0f);
  if ((without & 0x1c0) == 0) l.clearcoat_normal = V3f(0.0f);
  if ((without & 0xe00) == 0) l.sheen_roughness = std::numeric_limits<float>::quiet_NaN();
  if ((without & 0x7000) == 0) m.base.specular = 0.0f;
  if (lambertian)
    m.base.metallic = m.base.specular = 0.0f;
  else if (is_lambertian(m.base))
    m.base.metallic = 0.5f;
  EXPECT_TRUE(is_opaque_without_film(l));
  return m;
}

// Eight materials, parameter by parameter.
struct LayersInLanes {
  LaneVectors base_color, specular_color, coat_normal, sheen_color;
  LaneNumbers metallic, roughness, ior, specular, coat, coat_roughness, sheen_roughness, anisotropy;

  void set(size_t lane, const LayeredMaterial& m) {
    const BsdfParameters& p = m.base;
    base_color.set(lane, p.base_color), specular_color.set(lane, p.specular_color);
    metallic[lane] = p.metallic, roughness[lane] = p.roughness, ior[lane] = p.ior, specular[lane] = p.specular;
    const LayerParameters& l = m.layers;
    coat_normal.set(lane, l.clearcoat_normal), sheen_color.set(lane, l.sheen_color);
    coat[lane] = l.clearcoat, coat_roughness[lane] = l.clearcoat_roughness;
    sheen_roughness[lane] = l.sheen_roughness, anisotropy[lane] = l.anisotropy;
  }
  [[nodiscard]] LayeredBsdfOf<Lanes> seen_from(const Imath::Vec3<Lanes>& wo) const {
    LayerParametersOf<Lanes> layers;
    layers.clearcoat = coat.load(), layers.clearcoat_roughness = coat_roughness.load();
    layers.clearcoat_normal = coat_normal.load();
    layers.sheen_color = sheen_color.load(), layers.sheen_roughness = sheen_roughness.load();
    layers.anisotropy = anisotropy.load();
    return {{base_color.load(), metallic.load(), roughness.load(), ior.load(), specular.load(), specular_color.load()},
            layers,
            wo};
  }
};

// Calls compare(eight BSDFs, each of them, random numbers) for many sets.
template <typename Compare>
void for_many_layered_bsdfs(const Compare& compare) {
  Random random(5);
  for (int i = 0; i < 30'000 && !testing::Test::HasFatalFailure(); ++i) {
    LayersInLanes materials;
    LaneVectors wo;
    std::vector<LayeredBsdf> alone;
    const int kinds = i % 4; // sheen alone, no sheen, or anisotropy everywhere; else anything
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      LayeredMaterial m = any_opaque_layers(i % 5 == 0, random);
      if (kinds == 1) m.layers.clearcoat = m.layers.anisotropy = 0.0f;
      if (kinds == 2) m.layers.sheen_color = Rgb(0.0f);
      if (kinds == 3) m.layers.anisotropy = 0.3f + 0.7f * random.next_1d();
      wo.set(lane, any_direction_of_layers(random));
      materials.set(lane, m);
      alone.emplace_back(m.base, m.layers, wo[lane]);
    }
    compare(materials.seen_from(wo.load()), alone, random);
  }
}

TEST(EightLayeredBsdfs, EvaluateToTheBitsOfEach) {
  size_t zero = 0;
  for_many_layered_bsdfs(
      [&](const LayeredBsdfOf<Lanes>& together, const std::vector<LayeredBsdf>& alone, Random& random) {
        LaneVectors wi;
        for (size_t lane = 0; lane < Lanes::kCount; ++lane) wi.set(lane, any_direction_of_layers(random));
        const BsdfEvalOf<Lanes> eval = together.eval(wi.load());
        const Lanes narrow = together.narrow_density(wi.load(), eval.pdf, 0.1f);
        for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
          const BsdfEval expected = alone[lane].eval(wi[lane]);
          ASSERT_TRUE(same_bits(lane_of(eval.value, lane), expected.value));
          ASSERT_TRUE(same_bits(eval.pdf[lane], expected.pdf));
          ASSERT_TRUE(same_bits(eval.reflection_pdf[lane], expected.reflection_pdf));
          ASSERT_TRUE(same_bits(narrow[lane], alone[lane].narrow_density(wi[lane], expected.pdf, 0.1f)));
          zero += expected.pdf == 0.0f ? 1 : 0;
          ASSERT_TRUE(same_bits(lane_of(together.albedo(), lane), alone[lane].albedo()));
          ASSERT_TRUE(same_bits(together.cosine_begin()[lane], alone[lane].cosine_begin()));
          for (const float max_alpha : {1e-3f, 0.1f, 0.5f})
            ASSERT_TRUE(same_bits(together.smooth_share(max_alpha)[lane], alone[lane].smooth_share(max_alpha)));
          ASSERT_EQ(together.has_microfacets()[lane] != 0, alone[lane].has_microfacets());
        }
      });
  EXPECT_GT(zero, 10'000U);
}

TEST(EightLayeredBsdfs, AreSampledToTheBitsOfEach) {
  size_t absorbed = 0, glossy = 0, diffuse = 0;
  for_many_layered_bsdfs(
      [&](const LayeredBsdfOf<Lanes>& together, const std::vector<LayeredBsdf>& alone, Random& random) {
        LaneNumbers choice, x, y;
        for (size_t lane = 0; lane < Lanes::kCount; ++lane)
          choice[lane] = random.next_1d(), x[lane] = random.next_1d(), y[lane] = random.next_1d();
        const auto drawn = together.draw(choice.load(), {x.load(), y.load()});
        const auto reflections = together.sample_reflection(choice.load(), {x.load(), y.load()});
        for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
          if (alone[lane].has_microfacets()) {
            const V3f reflection = alone[lane].sample_reflection(choice[lane], {x[lane], y[lane]});
            ASSERT_TRUE(same_bits(lane_of(reflections, lane), reflection));
          }
          const std::optional<BsdfSample> sample = alone[lane].sample(choice[lane], {x[lane], y[lane]});
          ASSERT_EQ(drawn.found[lane] != 0, sample.has_value());
          ++(!sample ? absorbed : sample->lobe == Lobe::glossy ? glossy : diffuse);
          if (!sample) continue;
          ASSERT_TRUE(same_bits(lane_of(drawn.wi, lane), sample->wi));
          ASSERT_TRUE(same_bits(lane_of(drawn.weight, lane), sample->weight));
          ASSERT_TRUE(same_bits(drawn.pdf[lane], sample->pdf));
          ASSERT_TRUE(same_bits(drawn.reflection_pdf[lane], sample->reflection_pdf));
          ASSERT_EQ(drawn.glossy[lane] != 0, sample->lobe == Lobe::glossy);
        }
      });
  EXPECT_GT(absorbed, 10'000U);
  EXPECT_GT(glossy, 10'000U);
  EXPECT_GT(diffuse, 10'000U);
}

// The frame of anisotropic facets, also where there is no tangent or one along the normal.
TEST(EightFrames, HaveTheBitsOfEach) {
  Random random(6);
  for (int i = 0; i < 10'000; ++i) {
    LaneVectors normal, tangent;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const V3f n = any_direction_of_layers(random);
      normal.set(lane, n);
      const uint64_t kind = i % 2 == 0 ? 2 : random.next_u64() % 4;
      const V3f other = any_direction_of_layers(random);
      tangent.set(lane, kind == 0 ? V3f(0.0f) : kind == 1 ? n : other * random.next_1d());
    }
    const FrameOf<Lanes> together = FrameOf<Lanes>::with_tangent(normal.load(), tangent.load());
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const Frame alone = Frame::with_tangent(normal[lane], tangent[lane]);
      ASSERT_TRUE(same_bits(lane_of(together.tangent, lane), alone.tangent));
      ASSERT_TRUE(same_bits(lane_of(together.bitangent, lane), alone.bitangent));
      ASSERT_TRUE(same_bits(lane_of(together.normal, lane), alone.normal));
    }
  }
}

} // namespace
} // namespace kindling
