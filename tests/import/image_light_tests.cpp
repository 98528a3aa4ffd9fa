// EXT_lights_image_based: values, image encodings, and invalid lights.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/animated_members.h"
#include "tests/import/gltf_builder.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kindling::test {
namespace {

// PNG images: one pixel (255, 128, 0), the same with alpha 51, and two pixels in a row.
constexpr std::string_view kRgb =
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR42mP438AAAAQBAYD718vxAAAAAElFTkSuQmCC";
constexpr std::string_view kRgbd =
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP438BgDAAFtAGzLbAwAgAAAABJRU5ErkJggg==";
constexpr std::string_view kWide =
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAIAAAB7QOjdAAAADUlEQVR42mP438AARAAMfgL/8Hr2ggAAAABJRU5ErkJggg==";

GltfBuilder lit_by(std::string_view first, std::string_view others) {
  GltfBuilder builder = triangle();
  for (int i = 0; i < 6; ++i)
    builder.push("images", {{"uri", "data:image/png;base64," + std::string(i == 0 ? first : others)}});
  json coefficients = json::array();
  for (int i = 0; i < 9; ++i) coefficients.push_back({i, 0.5, -i});
  builder.root["extensions"]["EXT_lights_image_based"]["lights"] = json::array(
      {json{{"name", "sky"},
            {"intensity", 2.5},
            {"rotation", {0, 1, 0, 0}},
            {"irradianceCoefficients", coefficients},
            {"specularImageSize", 1},
            {"specularImages", json::array({json::array({5, 4, 3, 2, 1, 0}), json::array({0, 1, 2, 3, 4, 5})})}}});
  builder.root["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = 0;
  return builder;
}

json& light_of(GltfBuilder& builder) { return builder.root["extensions"]["EXT_lights_image_based"]["lights"][0]; }

Rgb texel(const Image& image) {
  float rgb[3];
  std::memcpy(rgb, image.pixels.data(), sizeof rgb);
  return {rgb[0], rgb[1], rgb[2]};
}

TEST(ImageLights, ReadsLights) {
  const Loaded loaded = load(lit_by(kRgbd, kRgb));
  ASSERT_TRUE(loaded.scene) << loaded.error;
  EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings[0];
  EXPECT_EQ(loaded.scene->scenes[0].image_light, 0);
  const ImageLight& light = loaded.scene->image_lights.at(0);
  EXPECT_EQ(light.name, "sky");
  EXPECT_EQ(light.intensity, 2.5f);
  EXPECT_EQ(light.rotation, Quatf(0, 0, 1, 0));
  EXPECT_EQ(light.irradiance_coefficients[8], Rgb(8, 0.5f, -8));
  ASSERT_NE(light.faces[0], nullptr);
  // sRGB of 128 is 0.2158605; the sixth face is image 0, which is RGBD with alpha 1 / 5.
  EXPECT_LT((texel(*light.faces[0]) - Rgb(1.0f, 0.2158605f, 0.0f)).length(), 1e-5f);
  EXPECT_LT((texel(*light.faces[5]) - Rgb(5.0f, 5.0f * std::pow(128.0f / 255.0f, 2.2f), 0.0f)).length(), 1e-4f);
}

TEST(ImageLights, DoesNotDecodeUnusedLights) {
  GltfBuilder builder = lit_by(kRgb, "AAAA");
  builder.root["scenes"][0].erase("extensions");
  const Loaded loaded = load(builder);
  EXPECT_TRUE(loaded.warnings.empty());
  EXPECT_EQ(loaded.scene->image_lights.at(0).faces[5], nullptr);
  EXPECT_EQ(loaded.scene->scenes[0].image_light, kNone);
}

TEST(ImageLights, UsesCoefficientsWithoutValidFaces) {
  for (const auto& [first, others] : {std::pair(kWide, kRgb), std::pair(kRgb, std::string_view("AAAA"))}) {
    const Loaded loaded = load(lit_by(first, others));
    ASSERT_TRUE(loaded.scene) << loaded.error;
    EXPECT_TRUE(loaded.warned("only the coefficients of the light are used"));
    for (const auto& face : loaded.scene->image_lights.at(0).faces) EXPECT_EQ(face, nullptr);
  }
}

TEST(ImageLights, RefusesInvalidLights) {
  const std::string place = "/extensions/EXT_lights_image_based/lights/0";
  const auto error = [](const char* property, const json& value) {
    GltfBuilder builder = lit_by(kRgb, kRgb);
    light_of(builder)[property] = value;
    return load(builder).error;
  };
  EXPECT_EQ(error("rotation", {0, 0, 0, 0}),
            place + "/rotation: a quaternion of length 0, expected length 1 (ROTATION_NON_UNIT)");
  EXPECT_EQ(error("irradianceCoefficients", json::array({json::array({1, 2, 3})})),
            place + "/irradianceCoefficients: 1 coefficients, expected 9 (ARRAY_LENGTH_NOT_IN_LIST)");
  for (const char* broken : {"[]", "7", "[1, 2]", "[[0, 1, 2, 3, 4]]", "[[0, 1, 2, 3, 4, 6]]", "[[0, 1, 2, 3, 4, -1]]",
                             "[[0, 1, 2, 3, 4, 0.5]]", "[[0, 1, 2, 3, 4, \"5\"]]"}) {
    EXPECT_EQ(error("specularImages", json::parse(broken)),
              place + "/specularImages: expected lists of 6 images of 6 (TYPE_MISMATCH)")
        << broken;
  }
  EXPECT_NE(error("irradianceCoefficients", json::parse("[[1e99, 0, 0]]")), "");
  EXPECT_NE(error("intensity", -1), "");
  GltfBuilder builder = lit_by(kRgb, kRgb);
  builder.root["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = 1;
  EXPECT_EQ(load(builder).error,
            "/scenes/0/extensions/EXT_lights_image_based/light: 1, the file has 1 image-based lights "
            "(UNRESOLVED_REFERENCE)");
  light_of(builder).erase("specularImages");
  EXPECT_EQ(load(builder).error, place + ": no 'specularImages' (UNDEFINED_PROPERTY)");
}

TEST(ImageLights, AnimatesRotationByQuaternion) {
  GltfBuilder builder = lit_by(kRgb, kRgb);
  const float s = std::sqrt(0.5f);
  const int input = builder.accessor<float>({0, 1}, kFloat, "SCALAR");
  const int output = builder.accessor<float>({0, 0, 0, 1, 0, s, 0, s}, kFloat, "VEC4");
  json target = {{"path", "pointer"}};
  target["extensions"]["KHR_animation_pointer"]["pointer"] = "/extensions/EXT_lights_image_based/lights/0/rotation";
  builder.push("animations", {{"channels", json::array({json{{"sampler", 0}, {"target", target}}})},
                              {"samplers", json::array({json{{"input", input}, {"output", output}}})}});
  Loaded loaded = load(builder);
  ASSERT_TRUE(loaded.scene) << loaded.error;
  animate_members(*loaded.scene, 1.0 / 3.0); // of 90 degrees about y
  const Quatf& rotation = loaded.scene->image_lights[0].rotation;
  EXPECT_NEAR(rotation.r, std::cos(kPi / 12.0f), 1e-5f);
  EXPECT_NEAR(rotation.v.y, std::sin(kPi / 12.0f), 1e-5f);
}

} // namespace
} // namespace kindling::test
