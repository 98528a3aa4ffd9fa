// Albedo and normal that guide denoisers: what mirrors and clear glass show.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/test_scenes.h"

#include "renderer/light/environment.h"

namespace kindling::test {
namespace {

struct Guides {
  Rgb albedo{0.0f};
  V3f normal{0.0f};
  Rgb first_albedo{0.0f}; // of Aov::albedo
};

// Returns the means over all pixels.
Guides guides_of(const World& world, const Camera& camera, IntegratorKind kind = IntegratorKind::path) {
  RenderSettings settings = small_render(V2i(8, 8), 64);
  settings.integrator.kind = kind;
  for (const Aov aov : {Aov::denoising_albedo, Aov::denoising_normal, Aov::albedo}) settings.aovs.insert(aov);
  const Result<RenderOutcome> outcome = render(world, camera, settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok());
  const auto mean = [&](Aov aov) {
    const std::vector<float> values = outcome.value().film.resolve(aov);
    V3f sum(0.0f);
    for (size_t i = 0; i < values.size(); ++i) sum[static_cast<int>(i % 3)] += values[i];
    return sum * (3.0f / static_cast<float>(values.size()));
  };
  return {mean(Aov::denoising_albedo), mean(Aov::denoising_normal), mean(Aov::albedo)};
}

void expect_channels(const V3f& value, const V3f& expected, float tolerance) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(value[c], expected[c], tolerance) << "channel " << c;
}

Material metal(const Rgb& color, float roughness) {
  Material material;
  material.base_color_factor = V4f(color.x, color.y, color.z, 1.0f);
  material.roughness_factor = roughness;
  return material;
}

const Rgb kMirrorColor(0.9f, 0.6f, 0.4f);
const Rgb kWallColor(0.2f, 0.5f, 0.8f);

// The camera looks down at 45 degrees onto a floor, which reflects a wall that faces +x.
std::unique_ptr<const World> floor_and_wall(const Material& floor) {
  return make_world(
      make_scene({floor, diffuse_material(kWallColor)}, {quad(V3f(-1, 0, 1), V3f(2, 0, 0), V3f(0, 0, -2), 0),
                                                         quad(V3f(-3, -20, 20), V3f(0, 0, -40), V3f(0, 40, 0), 1)}),
      accel::Kind::kdtree);
}
Camera towards_floor() { return beam_camera(V3f(2, 2, 0), V3f(0.0f), 0.1f); }

// Fresnel at 45 degrees adds (1 - cos 45)^5 = .0022 of what the color lacks to 1.
TEST(DenoisingGuides, MirrorsShowTheirReflection) {
  const Guides guides = guides_of(*floor_and_wall(metal(kMirrorColor, 0.0f)), towards_floor());
  expect_channels(guides.albedo, kMirrorColor * kWallColor, 0.002f);
  expect_channels(guides.normal, V3f(1, 0, 0), 1e-5f);
  expect_channels(guides.first_albedo, kMirrorColor, 0.003f);
}

TEST(DenoisingGuides, RoughMetalShowsItself) {
  const Guides guides = guides_of(*floor_and_wall(metal(kMirrorColor, 0.6f)), towards_floor());
  expect_channels(guides.albedo, guides.first_albedo, 1e-6f);
  expect_channels(guides.normal, V3f(0, 1, 0), 1e-5f);
}

// A smooth dielectric reflects 5 % at 45 degrees: its diffuse base counts.
TEST(DenoisingGuides, PolishedPlasticShowsItself) {
  Material plastic = metal(Rgb(0.5f), 0.0f);
  plastic.metallic_factor = 0.0f;
  const Guides guides = guides_of(*floor_and_wall(plastic), towards_floor());
  expect_channels(guides.albedo, guides.first_albedo, 1e-6f);
  expect_channels(guides.normal, V3f(0, 1, 0), 1e-5f);
}

// Mirrors behind mirrors: the throughput of all counts.
TEST(DenoisingGuides, ChainsOfMirrorsAreFollowed) {
  const auto world = make_world(make_scene({metal(kMirrorColor, 0.0f), diffuse_material(kWallColor)},
                                           {quad(V3f(-1, 0, 1), V3f(2, 0, 0), V3f(0, 0, -2), 0),
                                            quad(V3f(-2, 1, 1), V3f(0, 0, -2), V3f(0, 2, 0), 0), // faces +x
                                            quad(V3f(-20, 9, 20), V3f(0, 0, -40), V3f(40, 0, 0), 1)}),
                                accel::Kind::kdtree);
  const Guides guides = guides_of(*world, towards_floor());
  expect_channels(guides.albedo, kMirrorColor * kMirrorColor * kWallColor, 0.004f);
  expect_channels(guides.normal, V3f(0, -1, 0), 1e-5f);
}

// A block of clear glass before a wall. At each of its two faces 4 % are reflected, which end in
// the dark: the rest comes through, tinted.
TEST(DenoisingGuides, ClearGlassShowsTheWallBehind) {
  Material glass;
  glass.metallic_factor = 0.0f;
  glass.roughness_factor = 0.0f;
  glass.transmission_factor = 1.0f;
  glass.thickness_factor = 1.0f;
  const auto world = make_world(make_scene({glass, diffuse_material(kWallColor)},
                                           {quad(V3f(1, -5, -5), V3f(0, 10, 0), V3f(0, 0, 10), 0),  // faces +x
                                            quad(V3f(-1, -5, -5), V3f(0, 0, 10), V3f(0, 10, 0), 0), // faces -x
                                            quad(V3f(-3, -20, 20), V3f(0, 0, -40), V3f(0, 40, 0), 1)}),
                                accel::Kind::kdtree);
  const Guides guides = guides_of(*world, beam_camera(V3f(4, 0, 0), V3f(0.0f), 0.1f));
  // 64 x 64 paths, of which about 8 % reflect somewhere: standard error .0042 of the factor.
  const float through = (1.0f - 0.04f) * (1.0f - 0.04f) / (1.0f - 0.04f * 0.04f);
  expect_channels(guides.albedo, kWallColor * through, 0.02f);
  EXPECT_GT(guides.normal.x, 0.85f);
}

TEST(DenoisingGuides, MirrorsShowTheEnvironmentWithinRange) {
  const auto world =
      make_world(make_scene({metal(kMirrorColor, 0.0f)}, {quad(V3f(-1, 0, 1), V3f(2, 0, 0), V3f(0, 0, -2), 0)}),
                 accel::Kind::kdtree, std::make_shared<Environment>(Rgb(0.25f, 0.5f, 7.0f)));
  const Guides guides = guides_of(*world, towards_floor());
  expect_channels(guides.albedo, Rgb(kMirrorColor.x * 0.25f, kMirrorColor.y * 0.5f, 1.0f), 0.003f);
  expect_channels(guides.normal, V3f(0, 1, 0), 1e-5f);
}

TEST(DenoisingGuides, WhittedsTracerShowsFirstSurfaces) {
  const Guides guides = guides_of(*floor_and_wall(metal(kMirrorColor, 0.0f)), towards_floor(), IntegratorKind::whitted);
  expect_channels(guides.albedo, guides.first_albedo, 1e-6f);
  expect_channels(guides.normal, V3f(0, 1, 0), 1e-5f);
}

} // namespace
} // namespace kindling::test
