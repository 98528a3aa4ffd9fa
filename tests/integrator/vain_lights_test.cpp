// Lights are left out only where no light sample can contribute.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/path_stages.h"
#include "renderer/sampling/warp.h"
#include "tests/sampling/random.h"

#include <gtest/gtest.h>

namespace kindling::test {
namespace {

SurfacePoint clear_glass() {
  SurfacePoint surface;
  surface.layered = true;
  surface.layers.boundary = true;
  surface.layers.bsdf.transmission = 1.0f;
  surface.layers.bsdf.thin_walled = false;
  surface.bsdf = {.base_color = Rgb(0.4f, 0.8f, 0.6f), .metallic = 0.0f, .roughness = 0.0f};
  return surface;
}

bool reflects_sampled_lights(const SurfacePoint& surface) {
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const V2f u = random.next_2d();
    const V3f wo = sample_uniform_hemisphere(u), wi = sample_uniform_sphere(random.next_2d());
    for (const float eta : {1.5f, 1.0f / 1.5f, 1.001f, 2.4f}) {
      LayerParameters layers = surface.layers.bsdf;
      layers.eta = eta;
      if (!is_black(SurfaceBsdf(surface.bsdf, &layers, wo).eval(wi).value)) return true;
    }
  }
  return false;
}

TEST(VainLights, ClearGlassReflectsNoSampledLight) {
  const PathStages stages;
  for (const float roughness : {0.0f, 0.01f, kStraightRoughness})
    for (const float diffuse_transmission : {0.0f, 0.7f})
      for (const float iridescence : {0.0f, 1.0f}) {
        SurfacePoint glass = clear_glass();
        glass.bsdf.roughness = roughness;
        glass.layers.bsdf.diffuse_transmission = diffuse_transmission;
        glass.layers.bsdf.iridescence = iridescence;
        EXPECT_FALSE(stages.samples_light(glass)) << roughness;
        EXPECT_FALSE(reflects_sampled_lights(glass))
            << roughness << ", " << diffuse_transmission << ", " << iridescence;
      }
}

// Each of these adds a lobe that light samples find.
TEST(VainLights, AnythingElseIsLit) {
  void (*const changes[])(SurfacePoint&) = {
      [](SurfacePoint& s) { s.bsdf.roughness = 0.05f; },
      [](SurfacePoint& s) { s.bsdf.metallic = 0.2f; },
      [](SurfacePoint& s) { s.layers.bsdf.transmission = 0.9f; },
      [](SurfacePoint& s) { s.layers.bsdf.clearcoat = 0.5f, s.layers.bsdf.clearcoat_roughness = 0.3f; },
      [](SurfacePoint& s) { s.layers.bsdf.sheen_color = Rgb(0, 0, 0.5f), s.layers.bsdf.sheen_roughness = 0.5f; },
      [](SurfacePoint& s) { s.bsdf.roughness = 0.03f, s.layers.bsdf.anisotropy = 0.9f; },
  };
  for (const auto& change : changes) {
    SurfacePoint surface = clear_glass();
    change(surface);
    EXPECT_TRUE(PathStages().samples_light(surface)) << &change - changes;
    EXPECT_TRUE(reflects_sampled_lights(surface)) << &change - changes;
  }
  // Thin walls, and surfaces without layers.
  SurfacePoint thin = clear_glass(), plain = clear_glass();
  thin.layers.boundary = false;
  plain.layered = false;
  EXPECT_TRUE(PathStages().samples_light(thin));
  EXPECT_TRUE(PathStages().samples_light(plain));
}

// Regularization makes glass rough after the light is sampled.
TEST(VainLights, RegularizedGlassIsLit) {
  for (const Caustics caustics : {Caustics::regularized, Caustics::off}) {
    PathStages stages;
    stages.settings.caustics = caustics;
    EXPECT_TRUE(stages.samples_light(clear_glass()));
  }
}

} // namespace
} // namespace kindling::test
