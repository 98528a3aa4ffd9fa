// The diffuse part of BSDFs and the albedos of their lobes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/layered_bsdf.h"

#include "tests/bsdf/layered_materials.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

using test::describe;
using test::LayeredMaterial;
using test::Random;
using test::random_direction;
using test::random_material;
using test::view;

TEST(LobeParts, DiffusePartAndAlbedosOfLobes) {
  Random random(17);
  for (int i = 0; i < 20000; ++i) {
    const LayeredMaterial m = random_material(random, 0.0f);
    const V3f wo = random_direction(random);
    const V3f wi = random_direction(random);
    const LayeredBsdf layered(m.base, m.layers, wo);
    const Rgb value = layered.eval(wi).value, diffuse = layered.diffuse_value(wi);
    const LobeAlbedos albedos = layered.lobe_albedos();
    const Rgb sum = albedos.diffuse + albedos.glossy + albedos.transmission;
    for (int c = 0; c < 3; ++c) {
      ASSERT_GE(diffuse[c], 0.0f) << describe(m, wo.z);
      ASSERT_LE(diffuse[c], value[c] * (1.0f + 1e-5f) + 1e-7f) << describe(m, wo.z);
      ASSERT_NEAR(sum[c], layered.albedo()[c], 0.02f) << describe(m, wo.z); // saturated
    }
    ASSERT_EQ(layered.diffuse_value(-wi), Rgb(0.0f));
    const GltfBsdf plain(m.base, wo);
    const LayeredBsdf bare(m.base, {}, wo);
    ASSERT_LT((plain.diffuse_value(wi) - bare.diffuse_value(wi)).length(), 1e-5f) << i;
    ASSERT_LT((plain.lobe_albedos().diffuse - bare.lobe_albedos().diffuse).length(), 2e-3f) << i;
  }
}

// The albedo of the diffuse lobe is the integral of its value.
TEST(LobeParts, DiffuseAlbedoIsTheIntegralOfItsValue) {
  Random random(18);
  for (int i = 0; i < 40; ++i) {
    const BsdfParameters p = random_material(random, 0.2f).base;
    const V3f wo = random_direction(random);
    const GltfBsdf bsdf(p, wo);
    Rgb sum(0.0f);
    constexpr int kSteps = 2000; // the lobe does not depend on the azimuth
    for (int k = 0; k < kSteps; ++k) {
      const float mu = (static_cast<float>(k) + 0.5f) / kSteps;
      sum += bsdf.diffuse_value(view(mu, 0.25f)) * (2.0f * kPi / kSteps);
    }
    ASSERT_LT((sum - bsdf.lobe_albedos().diffuse).length(), 0.01f) << i;
  }
}

} // namespace
} // namespace kindling
