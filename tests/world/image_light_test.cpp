// Tests of EXT_lights_image_based: face orientation, rotation, seams, irradiance, precedence.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/image_light_environment.h"
#include "tests/integrator/test_scenes.h"
#include "tests/sampling/random.h"

#include <cstring>

namespace kindling::test {
namespace {

// The view through each face from within the cube: viewing direction, and up in its image.
struct View {
  V3f forward, up;
};
const View kViews[6] = {{{1, 0, 0}, {0, 1, 0}},  {{-1, 0, 0}, {0, 1, 0}}, {{0, 1, 0}, {0, 0, -1}},
                        {{0, -1, 0}, {0, 0, 1}}, {{0, 0, 1}, {0, 1, 0}},  {{0, 0, -1}, {0, 1, 0}}};

// Returns the cube map of a function of direction.
template <typename F>
ImageLight cube_of(int size, const F& radiance) {
  ImageLight light;
  for (size_t f = 0; f < 6; ++f) {
    auto face = std::make_shared<Image>();
    face->width = face->height = size;
    face->channels = 3;
    face->type = PixelType::f32;
    const V3f right = kViews[f].forward.cross(kViews[f].up);
    std::vector<Rgb> texels;
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        const float s = (static_cast<float>(x) + 0.5f) * 2.0f / static_cast<float>(size) - 1.0f;
        const float t = 1.0f - (static_cast<float>(y) + 0.5f) * 2.0f / static_cast<float>(size);
        texels.push_back(radiance((kViews[f].forward + right * s + kViews[f].up * t).normalized()));
      }
    face->pixels.resize(face->byte_count());
    std::memcpy(face->pixels.data(), texels.data(), face->pixels.size());
    light.faces[f] = face;
  }
  return light;
}

// Smooth, and different in all directions.
Rgb pattern(const V3f& d) { return {2.0f + d.x + 0.5f * d.y, 2.0f + d.y - 0.5f * d.z, 2.0f + d.z + 0.3f * d.x * d.y}; }

V3f random_direction(Random& random) {
  const float z = 1.0f - 2.0f * random.next_1d();
  const float r = std::sqrt(std::max(0.0f, 1.0f - z * z));
  const float phi = 2.0f * kPi * random.next_1d();
  return {r * std::cos(phi), r * std::sin(phi), z};
}

TEST(ImageLight, FacesAreViewsFromWithin) {
  const ImageLight light = cube_of(32, pattern);
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const V3f d = random_direction(random);
    const Rgb error = image_light_radiance(light, d) - pattern(d);
    // A texel is 1 / 16 wide; beyond an edge interpolation uses the nearest one.
    EXPECT_LT(error.length(), 0.06f) << d.x << ' ' << d.y << ' ' << d.z;
  }
  for (const V3f& d : {V3f(1, 0, 0), V3f(0, -1, 0), V3f(0, 0, 1)})
    EXPECT_LT((image_light_radiance(light, d) - pattern(d)).length(), 3e-3f);
}

TEST(ImageLight, RotationRotatesEnvironment) {
  ImageLight light = cube_of(16, pattern);
  Random random(2);
  const ImageLight still = light;
  light.rotation.setAxisAngle(V3f(0.3f, 1.0f, -0.5f).normalized(), 2.1f);
  for (int i = 0; i < 100; ++i) {
    const V3f d = random_direction(random);
    EXPECT_LT((image_light_radiance(light, light.rotation.rotateVector(d)) - image_light_radiance(still, d)).length(),
              1e-4f);
  }
  // Counterclockwise about +y: +x moves to -z.
  light.rotation.setAxisAngle({0, 1, 0}, kPi / 2.0f);
  EXPECT_LT((image_light_radiance(light, {0, 0, -1}) - pattern({1, 0, 0})).length(), 6e-3f);
}

TEST(ImageLight, EnvironmentIsImageTimesIntensity) {
  ImageLight light = cube_of(32, pattern);
  light.intensity = 3.0f;
  const auto environment = image_light_environment(light);
  Random random(3);
  Rgb mean(0.0f);
  for (int i = 0; i < 1000; ++i) {
    const V3f d = random_direction(random);
    EXPECT_LT((environment->radiance(d) - pattern(d) * 3.0f).length(), 0.2f);
  }
  // The pattern's mean over the sphere is 2.
  EXPECT_LT((environment->total_radiance * (0.25f * kInvPi) - Rgb(6.0f)).length(), 0.02f);
}

TEST(ImageLight, CoefficientsReproduceIrradiance) {
  ImageLight light;
  const float c[9] = {4.0f, 0.5f, -0.3f, 0.7f, 0.1f, -0.05f, 0.1f, 0.15f, -0.1f};
  for (size_t i = 0; i < 9; ++i) light.irradiance_coefficients[i] = Rgb(c[i], 2.0f * c[i], 0.5f * c[i]);
  const auto environment = image_light_environment(light);
  for (const V3f& n : {V3f(0, 1, 0), V3f(1, 0, 0), V3f(0, 0, -1), V3f(0.6f, 0.0f, 0.8f), V3f(-0.48f, 0.6f, 0.64f)}) {
    Rgb irradiance(0.0f);
    constexpr int kRows = 96;
    for (int row = 0; row < kRows; ++row)
      for (int column = 0; column < 2 * kRows; ++column) {
        const float theta = (static_cast<float>(row) + 0.5f) * kPi / kRows;
        const float phi = (static_cast<float>(column) + 0.5f) * kPi / kRows;
        const V3f d(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
        irradiance +=
            environment->radiance(d) * (std::max(d.dot(n), 0.0f) * std::sin(theta) * (kPi / kRows) * (kPi / kRows));
      }
    // Green (2000), "Spherical Harmonic Lighting", real harmonics.
    const float expected = c[0] * 0.282095f + 0.488603f * (c[1] * n.y + c[2] * n.z + c[3] * n.x) +
                           1.092548f * (c[4] * n.x * n.y + c[5] * n.y * n.z + c[7] * n.x * n.z) +
                           c[6] * 0.315392f * (3.0f * n.z * n.z - 1.0f) + c[8] * 0.546274f * (n.x * n.x - n.y * n.y);
    EXPECT_NEAR(irradiance.x, expected, 0.01f * expected);
    EXPECT_NEAR(irradiance.y, 2.0f * expected, 0.02f * expected);
  }
}

TEST(ImageLight, PrecedenceIsOptionFileStudio) {
  const auto build = [](const std::shared_ptr<const Environment>& option) {
    Scene scene = make_scene({diffuse_material(Rgb(0.5f))}, {quad(V3f(-1, 0, 1), V3f(2, 0, 0), V3f(0, 0, -2), 0)});
    scene.image_lights.push_back(cube_of(4, [](const V3f&) { return Rgb(7.0f); }));
    if (scene.scenes.empty()) scene.scenes.push_back({.nodes = {0}});
    scene.scenes[0].image_light = 0;
    PosedScene posed = pose_scene(scene, {}).value();
    WorldOptions options;
    options.environment = option;
    return build_world(std::move(scene), std::move(posed), options, nullptr, nullptr).value();
  };
  EXPECT_NEAR(build(nullptr)->lights.environment_radiance(V3f(0, 1, 0)).x, 7.0f, 0.01f);
  EXPECT_EQ(build(std::make_shared<Environment>(Rgb(2.0f)))->lights.environment_radiance(V3f(0, 1, 0)).x, 2.0f);
}

} // namespace
} // namespace kindling::test
