// --caustics: images with the option match, to the bit, scenes whose materials are changed by hand.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/test_scenes.h"

#include <cstring>

namespace kindling::test {
namespace {

Material mirror_material(float roughness) {
  Material mirror;
  mirror.base_color_factor = V4f(0.9f, 0.8f, 0.7f, 1.0f);
  mirror.metallic_factor = 1.0f;
  mirror.roughness_factor = roughness;
  mirror.double_sided = true;
  return mirror;
}

// A floor that is lit by a small lamp, directly and by reflection from a wall beside it.
std::unique_ptr<const World> lit_floor(const Material& wall, const Material& floor = diffuse_material(Rgb(0.7f))) {
  return make_world(make_scene({floor, wall, emissive_material(Rgb(40.0f, 30.0f, 20.0f))},
                               {quad(V3f(-2, 0, 2), V3f(4, 0, 0), V3f(0, 0, -4), 0),
                                quad(V3f(-2, 0, -2), V3f(4, 0, 0), V3f(0, 3, 0), 1),
                                quad(V3f(-0.2f, 2, 0.5f), V3f(0.4f, 0, 0), V3f(0, 0, 0.4f), 2)}),
                    accel::Kind::embree);
}

// Sees the floor alone, so that only bounces reach the wall.
Camera floor_camera() { return beam_camera(V3f(0, 5, 4), V3f(0, 0, 0), 0.5f, V2i(16, 16)); }

Film render_floor(const World& world, Caustics caustics, uint32_t spp, const Camera& camera = floor_camera()) {
  RenderSettings settings = small_render(V2i(16, 16), spp);
  settings.integrator.caustics = caustics;
  Result<RenderOutcome> outcome = render(world, camera, settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok());
  return std::move(outcome).value().film;
}

bool same_image(const Film& a, const Film& b) {
  const std::vector<float> x = a.resolve_rgba(), y = b.resolve_rgba();
  return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof(float)) == 0;
}

constexpr Caustics kAll[] = {Caustics::full, Caustics::regularized, Caustics::off};

TEST(Caustics, NamesRoundTrip) {
  for (const Caustics caustics : kAll) EXPECT_EQ(caustics_from_name(caustics_name(caustics)), caustics);
  EXPECT_FALSE(caustics_from_name("on"));
}

// Without narrow lobes the options change nothing.
TEST(Caustics, DiffuseScenesAreUnchanged) {
  const auto world = lit_floor(diffuse_material(Rgb(0.5f)));
  const Film full = render_floor(*world, Caustics::full, 16);
  EXPECT_TRUE(same_image(render_floor(*world, Caustics::regularized, 16), full));
  EXPECT_TRUE(same_image(render_floor(*world, Caustics::off, 16), full));
}

// Off: a metal wall is black as seen from a diffuse floor.
TEST(Caustics, OffMakesMetalBlack) {
  const Film off = render_floor(*lit_floor(mirror_material(0.1f)), Caustics::off, 16);
  const Film black = render_floor(*lit_floor(diffuse_material(Rgb(0.0f))), Caustics::full, 16);
  EXPECT_TRUE(same_image(off, black));
  const Film full = render_floor(*lit_floor(mirror_material(0.1f)), Caustics::full, 256);
  EXPECT_GT(mean_of(full).luminance,
            mean_of(off).luminance + 4.5 * std::hypot(mean_of(full).standard_error, mean_of(off).standard_error));
}

// Off: solid glass absorbs the light that a diffuse floor would receive through it, and its coat is
// removed; a thin wall still transmits light in a straight line.
TEST(Caustics, OffMakesGlassBlackButNotThinWalls) {
  Material glass = mirror_material(0.0f);
  glass.metallic_factor = 0.0f;
  glass.transmission_factor = 1.0f;
  glass.clearcoat_factor = 1.0f;
  Material solid = glass;
  solid.thickness_factor = 1.0f;
  const Film black = render_floor(*lit_floor(diffuse_material(Rgb(0.0f))), Caustics::full, 16);
  EXPECT_TRUE(same_image(render_floor(*lit_floor(solid), Caustics::off, 16), black));

  // The thin wall is between the lamp and the floor.
  const auto below_a_thin_wall = [&](const Material& thin_wall) {
    return make_world(make_scene({diffuse_material(Rgb(0.7f)), thin_wall, emissive_material(Rgb(40.0f))},
                                 {quad(V3f(-2, 0, 2), V3f(4, 0, 0), V3f(0, 0, -4), 0),
                                  quad(V3f(-2, 1, 2), V3f(4, 0, 0), V3f(0, 0, -4), 1),
                                  quad(V3f(-0.2f, 2, 0.5f), V3f(0.4f, 0, 0), V3f(0, 0, 0.4f), 2)}),
                      accel::Kind::embree);
  };
  glass.clearcoat_factor = 0.0f;
  glass.specular_factor = 0.0f; // nothing is reflected: all three are the same
  const auto world = below_a_thin_wall(glass);
  const Mean full = mean_of(render_floor(*world, Caustics::full, 64));
  EXPECT_GT(full.luminance, 0.1);
  for (const Caustics caustics : {Caustics::regularized, Caustics::off}) {
    const Mean regularized = mean_of(render_floor(*world, caustics, 64));
    EXPECT_NEAR(regularized.luminance, full.luminance,
                4.5 * std::hypot(full.standard_error, regularized.standard_error));
  }
}

// Mirrors seen by the camera, and mirrors in mirrors, are never changed.
TEST(Caustics, OffKeepsReflectionsInMirrors) {
  const auto world = lit_floor(mirror_material(0.1f), mirror_material(0.0f));
  EXPECT_TRUE(same_image(render_floor(*world, Caustics::off, 16), render_floor(*world, Caustics::full, 16)));
}

// Regularized: for the first sample the wall has alpha = 0.3 = 0.5477^2.
TEST(Caustics, RegularizedWidensTheWall) {
  EXPECT_FLOAT_EQ(regularized_alpha(1.0f, 0), 0.3f);
  const auto smooth = lit_floor(mirror_material(0.1f)), rough = lit_floor(mirror_material(std::sqrt(0.3f)));
  const Film regularized = render_floor(*smooth, Caustics::regularized, 1);
  EXPECT_TRUE(same_image(regularized, render_floor(*rough, Caustics::full, 1)));
  EXPECT_FALSE(same_image(regularized, render_floor(*smooth, Caustics::full, 1)));
  // Rougher walls are unchanged.
  const auto rougher = lit_floor(mirror_material(0.6f));
  EXPECT_TRUE(
      same_image(render_floor(*rougher, Caustics::regularized, 16), render_floor(*rougher, Caustics::full, 16)));
}

TEST(Caustics, RegularizedWidthFallsWithTheSample) {
  EXPECT_NEAR(regularized_alpha(1.0f, 63), 0.15f, 1e-6f);
  EXPECT_NEAR(regularized_alpha(1.0f, 4095), 0.075f, 1e-6f);
  EXPECT_FLOAT_EQ(regularized_alpha(0.5f, 0), 0.15f);
  EXPECT_EQ(regularized_alpha(0.0f, 0), 0.0f); // mirrors in mirrors stay sharp
  WidestLobe widest;
  widest.add(Lobe::glossy, 0.5f);
  EXPECT_NEAR(widest.alpha(), 0.25f, 0.5f / 255.0f);
  widest.add(Lobe::glossy, 0.1f);
  EXPECT_NEAR(widest.alpha(), 0.25f, 0.5f / 255.0f);
  widest.add(Lobe::diffuse, 0.0f);
  EXPECT_EQ(widest.alpha(), 1.0f);
}

// Wider lobes reflect as much light: in a closed white box nothing is lost or gained.
TEST(Caustics, RegularizedConservesEnergy) {
  Material white;
  white.metallic_factor = 0.5f;
  white.roughness_factor = 0.05f;
  const auto world = make_world(make_scene({white}, {sphere(V3f(0.0f), 1.0f, 32, 0)}), accel::Kind::embree,
                                std::make_shared<Environment>(Rgb(1.0f)));
  const Film film =
      render_floor(*world, Caustics::regularized, 64, beam_camera(V3f(1, 2, 3), V3f(0.0f), 0.5f, V2i(16, 16)));
  // The tables of albedos are exact to 0.2 %.
  EXPECT_NEAR(mean_of(film).luminance, 1.0, 4.5 * mean_of(film).standard_error + 2e-3);
}

} // namespace
} // namespace kindling::test
