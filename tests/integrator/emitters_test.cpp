// Emissive meshes in all poses, textured and scaled: light sampling matches BSDF sampling.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/test_scenes.h"
#include "tests/light/light_fixtures.h"

namespace kindling::test {
namespace {

struct Case {
  const char* name;
  V3f scale;
  int copies;    // a single one is baked into the world's triangles, several are instances
  bool textured; // bright in one corner, black in another
  float strength;
  bool double_sided;
  float clearcoat = 0.0f;
};

// A bent lamp of many small quads, so that the light tree has a choice.
Primitive lamp_mesh(int material) {
  Primitive mesh;
  mesh.material = material;
  constexpr int kSteps = 6;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      const V2f uv(static_cast<float>(i) / kSteps, static_cast<float>(j) / kSteps);
      mesh.positions.emplace_back(uv.x - 0.5f, 0.3f * square(uv.x - 0.5f), uv.y - 0.5f);
      if (mesh.texcoords.empty()) mesh.texcoords.emplace_back();
      mesh.texcoords[0].push_back(uv);
    }
  }
  for (uint32_t i = 0; i < kSteps; ++i) {
    for (uint32_t j = 0; j < kSteps; ++j) {
      const uint32_t a = i * (kSteps + 1) + j, b = a + kSteps + 1;
      for (const uint32_t index : {a, b, b + 1, a, b + 1, a + 1}) mesh.indices.push_back(index); // faces down
    }
  }
  return mesh;
}

Scene floor_under_lamp(const Case& c, bool sampled) {
  Material lamp = emissive_material(Rgb(1.0f, 0.5f, 0.25f));
  lamp.double_sided = c.double_sided;
  lamp.clearcoat_factor = c.clearcoat;
  lamp.emissive_strength = c.strength;
  if (c.textured) lamp.emissive_texture.texture = 0;
  if (!sampled) { // BLEND emitters are found by BSDF sampling alone
    lamp.alpha_mode = AlphaMode::blend;
    lamp.base_color_factor.w = 0.9999999f;
  }
  Material floor = diffuse_material(Rgb(0.8f));
  floor.roughness_factor = 0.4f;
  floor.specular_factor = 1.0f;
  Scene scene = make_scene({floor, lamp}, {quad(V3f(-5, 0, 5), V3f(10, 0, 0), V3f(0, 0, -10), 0), lamp_mesh(1)});
  scene.nodes[1].local.scale = c.scale;
  scene.nodes[1].local.translation = V3f(0, 1, -0.5f);
  for (int i = 1; i < c.copies; ++i) {
    Node copy = scene.nodes[1];
    copy.local.translation =
        V3f(1.3f * static_cast<float>(i % 3) - 1.0f, 1.0f, 1.4f * static_cast<float>(i / 3) - 2.0f);
    copy.local.scale *= i % 2 == 1 ? V3f(-1, 1, 1) : V3f(0.7f, 1, 1.2f);
    scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
    scene.nodes.push_back(copy);
  }
  if (c.textured) {
    auto image = std::make_shared<Image>();
    image->width = image->height = 2;
    image->channels = 3;
    for (const int level : {255, 40, 0, 120}) image->pixels.insert(image->pixels.end(), 3, std::byte(level));
    SceneTexture texture;
    texture.image = image;
    scene.textures.push_back(texture);
  }
  return scene;
}

class Emitters : public testing::TestWithParam<Case> {};

TEST_P(Emitters, LightSamplingMatchesBsdfSampling) {
  const Case& c = GetParam();
  const auto mean_with = [&](bool sampled, uint32_t spp) {
    const auto world = make_world(floor_under_lamp(c, sampled), accel::Kind::embree);
    EXPECT_EQ(world->lights.light_count > 0, sampled);
    RenderSettings settings = small_render(V2i(16, 16), spp);
    settings.integrator.max_bounces = 0;
    return render_mean(*world, beam_camera(V3f(0.3f, 0.7f, 2), V3f(0.0f), 0.5f, V2i(16, 16)), settings);
  };
  const Mean both = mean_with(true, 128), bsdf_only = mean_with(false, 512);
  EXPECT_LT(2.0 * both.standard_error, bsdf_only.standard_error);
  EXPECT_LT(bsdf_only.standard_error, 0.02 * bsdf_only.luminance);
  EXPECT_NEAR(both.luminance, bsdf_only.luminance, 4.5 * std::hypot(both.standard_error, bsdf_only.standard_error));
}

INSTANTIATE_TEST_SUITE_P(Poses, Emitters,
                         testing::Values(Case{"baked", V3f(1.0f), 1, false, 1.0f, false},
                                         Case{"uneven", V3f(2.0f, 3.0f, 0.4f), 1, false, 1.0f, false},
                                         Case{"mirrored", V3f(-1.5f, 1.0f, 1.0f), 1, false, 1.0f, false},
                                         Case{"strong", V3f(1.0f), 1, false, 25.0f, true},
                                         Case{"textured", V3f(-1.0f, 1.0f, 1.5f), 1, true, 4.0f, false},
                                         Case{"instanced", V3f(0.6f, 1.0f, 0.5f), 6, false, 1.0f, false},
                                         Case{"instanced_textured", V3f(0.6f, 1.0f, 0.5f), 6, true, 3.0f, true},
                                         Case{"coated", V3f(2.0f, 1.0f, 2.0f), 1, false, 1.0f, false, 1.0f},
                                         Case{"coated_instances", V3f(0.6f, 1.0f, 0.5f), 6, false, 1.0f, true, 0.7f}),
                         [](const auto& pose) { return std::string(pose.param.name); });

// Light sampling leaves the uniform part of a sky to the BSDF; together they find all of it.
TEST(EnvironmentLight, DiffuseFloorUnderAnUnevenSky) {
  const auto sky = std::make_shared<Environment>(uneven_image(24, 12), 0.7f, 0.5f);
  double expected = 0.0; // irradiance
  constexpr int kSteps = 12 * 48;
  for (int y = 0; y < kSteps / 2; ++y) { // the upper half
    const double theta = std::numbers::pi * (y + 0.5) / kSteps;
    for (int x = 0; x < 2 * kSteps; ++x) {
      const double phi = std::numbers::pi * (x + 0.5) / kSteps;
      const V3f d(static_cast<float>(std::sin(theta) * std::cos(phi)), static_cast<float>(std::cos(theta)),
                  static_cast<float>(std::sin(theta) * std::sin(phi)));
      expected += static_cast<double>(luminance(sky->radiance(d))) * std::cos(theta) * std::sin(theta);
    }
  }
  expected *= 0.8 / std::numbers::pi * std::pow(std::numbers::pi / kSteps, 2.0);
  const auto world =
      make_world(make_scene({diffuse_material(Rgb(0.8f))}, {quad(V3f(-5, 0, 5), V3f(10, 0, 0), V3f(0, 0, -10), 0)}),
                 accel::Kind::embree, sky);
  RenderSettings settings = small_render(V2i(16, 16), 512);
  settings.integrator.max_bounces = 0;
  const Mean mean = render_mean(*world, beam_camera(V3f(0.3f, 2, 1), V3f(0.0f), 0.5f, V2i(16, 16)), settings);
  EXPECT_NEAR(mean.luminance, expected, 4.5 * mean.standard_error + 5e-4 * expected); // the error of the quadrature
  EXPECT_LT(mean.standard_error, 0.01 * expected);
}

} // namespace
} // namespace kindling::test
