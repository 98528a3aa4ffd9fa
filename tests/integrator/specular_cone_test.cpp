// Cones after spheres of glass and mirrors, and images in which they average the environment.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/specular_cone.h"

#include "tests/integrator/glass_bell.h"
#include "tests/integrator/test_scenes.h"

#include <gtest/gtest.h>

namespace kindling::test {
namespace {

constexpr float kRadius = 2.0f;

struct Met {
  std::unique_ptr<const World> world;
  accel::Hit hit;
  SurfacePoint surface;
};

// A sphere around the origin, met by a ray along -y at a distance from its axis.
Met sphere_met(float offset) {
  Met met;
  met.world =
      make_world(make_scene({diffuse_material(Rgb(0.5f))}, {sphere(V3f(0.0f), kRadius, 128, 0)}), accel::Kind::kdtree);
  const accel::Ray ray{.origin = V3f(offset, 9, 0.1f), .t_min = 0.0f, .direction = V3f(0, -1, 0), .t_max = kInfinity};
  met.hit = met.world->accelerator().intersect(ray);
  EXPECT_TRUE(met.hit.is_hit());
  met.world->surface_at(ray, met.hit, met.surface);
  return met;
}

V3f refracted(const V3f& direction, const V3f& normal, float eta) {
  const float cosine = -direction.dot(normal);
  const float beyond = std::sqrt(1.0f - (1.0f - cosine * cosine) / (eta * eta));
  return direction / eta + normal * (cosine / eta - beyond);
}

// Returns the angle between what becomes of two parallel rays a small way apart, across the plane
// of incidence, over that way.
template <typename F>
float angle_per_meter(const V3f& normal, const F& scattered) {
  constexpr float kStep = 1e-2f;
  const V3f across = normal.cross(V3f(0, 1, 0)).normalized();
  const V3f beside = (normal + across * (kStep / kRadius)).normalized();
  return (scattered(beside) - scattered(normal)).length() / kStep;
}

// By 128 slices normals turn as on the sphere within 0.1 %; the step adds as much.
TEST(SpecularCone, WidensAsNeighboringRaysDo) {
  constexpr float kWidth = 1e-3f, kSpread = 0.02f;
  const V3f down(0, -1, 0);
  for (const float offset : {0.3f, 0.8f, 1.5f}) {
    const Met met = sphere_met(offset);
    const V3f& normal = met.surface.shading_normal;
    const auto mirrored = [&](const V3f& n) { return down - n * (2.0f * n.dot(down)); };
    const RayCone reflected =
        specular_cone(*met.world, met.hit, met.surface, mirrored(normal), 1.0f, {kWidth, kSpread});
    EXPECT_EQ(reflected.width_m, kWidth);
    EXPECT_NEAR(reflected.spread - kSpread, kWidth * angle_per_meter(normal, mirrored), 3e-3f * kWidth / kRadius);
    for (const float eta : {1.5f, 1.33f}) {
      const auto bent = [&](const V3f& n) { return refracted(down, n, eta); };
      const RayCone beyond = specular_cone(*met.world, met.hit, met.surface, bent(normal), eta, {kWidth, kSpread});
      EXPECT_NEAR(beyond.spread - kSpread / eta, kWidth * angle_per_meter(normal, bent), 3e-3f * kWidth / kRadius);
    }
  }
}

// The bundle leaves a sphere by a normal that turns by width / radius.
TEST(SpecularCone, CoversNarrowLobesAlone) {
  Met met = sphere_met(0.3f);
  constexpr float kEta = 1.0f / 1.5f, kWidth = 0.1f, kSpread = 0.02f;
  const float spread = 1.5f * kSpread + 0.5f * kWidth / kRadius; // along the normal, leaving glass
  const auto covers = [&](float lobe) {
    met.surface.bsdf.roughness = std::sqrt(lobe); // of 2 * 0.5 * roughness^2
    return bundle_covers_lobe(*met.world, met.hit, met.surface, kEta, {kWidth, kSpread}, 0.5f * kInvPi);
  };
  EXPECT_TRUE(covers(0.99f * spread));
  EXPECT_FALSE(covers(1.01f * spread));
}

// Beads of glass, one behind another, below a sky with a lamp, and with another lamp beside them.
Mean beads(uint32_t samples, float filter, float roughness) {
  std::vector<Primitive> all;
  for (int i = 0; i < 27; ++i)
    all.push_back(sphere(
        V3f(static_cast<float>(i % 3), static_cast<float>(i / 3 % 3), static_cast<float>(i / 9)) * 0.6f - V3f(0.6f),
        0.29f, 24, 0));
  all.push_back(quad(V3f(-1.5f, 1.5f, -0.5f), V3f(0, 0, 1), V3f(1, 0.4f, 0), 1));
  const auto world = make_world(make_scene({glass_material(roughness), emissive_material(Rgb(3.0f))}, std::move(all)),
                                accel::Kind::kdtree, sky_with_a_lamp(60.0f));
  RenderSettings settings = small_render({24, 24}, samples);
  settings.integrator.environment_filter = filter;
  return render_mean(*world, bell_camera(settings.size_px), settings);
}

// Clear glass, and glass whose lobes are narrower than the bundles of so many samples.
TEST(EnvironmentFilter, LeavesLessNoiseBehindUnevenGlass) {
  for (const float roughness : {0.0f, 0.15f}) {
    const Mean point = beads(16, 0.0f, roughness), area = beads(16, 1.0f, roughness);
    EXPECT_LT(area.standard_error, 0.9 * point.standard_error) << roughness;
    EXPECT_GT(area.standard_error, 0.1 * point.standard_error) << roughness;
  }
}

TEST(EnvironmentFilter, HasTheSameMeanWithManySamples) {
  for (const float roughness : {0.0f, 0.08f}) {
    const Mean point = beads(1024, 0.0f, roughness), area = beads(1024, 1.0f, roughness);
    EXPECT_NE(area.luminance, point.luminance) << roughness;
    EXPECT_NEAR(area.luminance, point.luminance, 4.5 * std::hypot(area.standard_error, point.standard_error))
        << roughness;
    EXPECT_LT(point.standard_error, 0.015 * point.luminance) << roughness; // so a tenth more or less light would fail
  }
}

} // namespace
} // namespace kindling::test
