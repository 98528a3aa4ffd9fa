// Tests of emission below a clear coat: closed form at hits, and equality with light samples.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/test_scenes.h"

#include <cstring>

namespace kindling::test {
namespace {

Scene lamp(const std::function<void(Material&)>& change) {
  Material material = emissive_material(Rgb(3.0f, 2.0f, 1.0f));
  change(material);
  return make_scene({material}, {quad(V3f(-1, 0, 1), V3f(2, 0, 0), V3f(0, 0, -2), 0)});
}

// Schlick's Fresnel with 0.04.
double reflected(double cos_theta) { return 0.04 + 0.96 * std::pow(1.0 - cos_theta, 5.0); }

TEST(CoatedEmission, IsAttenuatedByCoatFresnel) {
  for (const float clearcoat : {0.0f, 0.4f, 1.0f}) {
    const auto world = make_world(lamp([&](Material& m) { m.clearcoat_factor = clearcoat; }), accel::Kind::embree);
    for (const float degrees : {0.0f, 40.0f, 75.0f, 88.0f}) {
      const float angle = degrees * kPi / 180.0f;
      const V3f wo(std::sin(angle), std::cos(angle), 0.0f);
      const V3f target(0.1f, 0.0f, 0.2f);
      const accel::Ray ray{.origin = target + wo, .t_min = 0.0f, .direction = -wo, .t_max = kInfinity};
      const accel::Hit hit = world->accelerator().intersect(ray);
      ASSERT_TRUE(hit.is_hit());
      SurfacePoint surface;
      world->surface_at(ray, hit, surface);
      const double expected =
          3.0 * (1.0 - static_cast<double>(clearcoat) * reflected(std::cos(static_cast<double>(angle))));
      EXPECT_NEAR(surface.emitted.x, expected, 1e-5) << clearcoat << ", " << degrees;
      // The same triangle, evaluated as a light and sampled.
      ASSERT_NE(surface.emissive_triangle, accel::kNoId);
      EXPECT_NEAR(world->lights.emitted(surface.emissive_triangle, 0.3f, 0.3f, -wo).x, expected, 1e-5);
      const auto sample = world->lights.sample(target + wo * 20.0f, -wo, 0.3f, {0.4f, 0.6f});
      ASSERT_TRUE(sample);
      const double seen = static_cast<double>(std::fabs(sample->wi.y));
      EXPECT_NEAR(sample->radiance.x, 3.0 * (1.0 - static_cast<double>(clearcoat) * reflected(seen)), 1e-5);
    }
  }
}

// Emission inside of a volume is not covered by the outer coat.
TEST(CoatedEmission, VolumeIsCoatedOnOuterSide) {
  const auto world = make_world(lamp([](Material& m) {
                                  m.clearcoat_factor = 1.0f;
                                  m.transmission_factor = 1.0f;
                                  m.thickness_factor = 1.0f;
                                  m.double_sided = true;
                                }),
                                accel::Kind::embree);
  for (const float side : {1.0f, -1.0f}) {
    const accel::Ray ray{
        .origin = V3f(0.1f, side, 0.2f), .t_min = 0.0f, .direction = V3f(0, -side, 0), .t_max = kInfinity};
    const accel::Hit hit = world->accelerator().intersect(ray);
    ASSERT_TRUE(hit.is_hit());
    SurfacePoint surface;
    world->surface_at(ray, hit, surface);
    const float expected = side > 0.0f ? 3.0f * 0.96f : 3.0f;
    EXPECT_NEAR(surface.emitted.x, expected, 1e-5f) << side;
    EXPECT_NEAR(world->lights.emitted(surface.emissive_triangle, 0.3f, 0.3f, ray.direction).x, expected, 1e-5f);
  }
}

TEST(CoatedEmission, TexturedCoatIsLeftToBsdfSampling) {
  Scene scene = lamp([](Material& m) {
    m.clearcoat_factor = 1.0f;
    m.clearcoat_texture.texture = 0;
  });
  auto image = std::make_shared<Image>();
  image->width = image->height = 1;
  image->channels = 3;
  image->pixels.assign(3, std::byte{128});
  scene.textures.push_back({.image = image});
  scene.meshes[0].primitives[0].texcoords = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  const auto world = make_world(std::move(scene), accel::Kind::embree);
  EXPECT_EQ(world->lights.light_count, 0U);
  const accel::Ray ray{.origin = V3f(0.1f, 1, 0.2f), .t_min = 0.0f, .direction = V3f(0, -1, 0), .t_max = kInfinity};
  const accel::Hit hit = world->accelerator().intersect(ray);
  ASSERT_TRUE(hit.is_hit());
  SurfacePoint surface;
  world->surface_at(ray, hit, surface);
  EXPECT_NEAR(surface.emitted.x, 3.0f * (1.0f - 0.04f * 128.0f / 255.0f), 1e-5f);
}

} // namespace
} // namespace kindling::test
