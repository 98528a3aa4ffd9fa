// KHR_animation_pointer: targets in materials, cameras, lights and meshes, and invalid ones.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/animated_members.h"
#include "tests/import/gltf_builder.h"

#include <gtest/gtest.h>

namespace kindling::test {
namespace {

// Adds one channel from `from` at 0 s to `to` at 1 s.
GltfBuilder pointing(const char* pointer, const std::vector<float>& from, const std::vector<float>& to,
                     const char* type) {
  GltfBuilder builder = triangle();
  std::vector<float> values = from;
  values.insert(values.end(), to.begin(), to.end());
  const int input = builder.accessor<float>({0, 1}, kFloat, "SCALAR");
  const int output = builder.accessor(values, kFloat, type);
  json target = {{"path", "pointer"}};
  target["extensions"]["KHR_animation_pointer"]["pointer"] = pointer;
  builder.push("animations", {{"channels", json::array({json{{"sampler", 0}, {"target", target}}})},
                              {"samplers", json::array({json{{"input", input}, {"output", output}}})}});
  builder.push("materials", {{"name", "animated"}});
  return builder;
}

Scene at_half(const GltfBuilder& builder) {
  Loaded loaded = load(builder);
  EXPECT_TRUE(loaded.scene) << loaded.error;
  EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings.at(0);
  animate_members(*loaded.scene, 0.5);
  return std::move(*loaded.scene);
}

TEST(AnimationPointer, AnimatesMaterials) {
  const Scene factor =
      at_half(pointing("/materials/0/pbrMetallicRoughness/baseColorFactor", {0, 0, 0, 1}, {1, 0.5f, 0, 0}, "VEC4"));
  EXPECT_EQ(factor.materials[0].base_color_factor,
            V4f(0.5f, 0.25f, 0, 0.5f)); // a color is not normalized as a quaternion
  const Scene strength =
      at_half(pointing("/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength", {0}, {8}, "SCALAR"));
  EXPECT_EQ(strength.materials[0].emissive_strength, 4.0f);
}

TEST(AnimationPointer, AnimatesCamerasAndLights) {
  GltfBuilder camera = pointing("/cameras/0/perspective/yfov", {0.5f}, {1.5f}, "SCALAR");
  camera.push("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.1}}}});
  EXPECT_EQ(at_half(camera).cameras[0].yfov_rad, 1.0f);

  GltfBuilder light = pointing("/extensions/KHR_lights_punctual/lights/0/color", {0, 0, 0}, {1, 0.5f, 0.25f}, "VEC3");
  light.root["extensions"]["KHR_lights_punctual"]["lights"] = json::array({json{{"type", "point"}}});
  EXPECT_EQ(at_half(light).lights[0].color, Rgb(0.5f, 0.25f, 0.125f));
}

TEST(AnimationPointer, AnimatesWeightsOfMeshesAndNodes) {
  const auto morphed = [](const char* pointer, const std::vector<float>& from, const std::vector<float>& to) {
    GltfBuilder builder = pointing(pointer, from, to, "SCALAR");
    builder.root["meshes"][0]["primitives"][0]["targets"] = json::array({json{{"POSITION", 0}}, json{{"POSITION", 0}}});
    return builder;
  };
  EXPECT_EQ(at_half(morphed("/meshes/0/weights", {0, 1}, {1, 0})).meshes[0].weights, (std::vector<float>{0.5f, 0.5f}));
  EXPECT_EQ(at_half(morphed("/meshes/0/weights/1", {0}, {1})).meshes[0].weights, (std::vector<float>{0, 0.5f}));
  const Scene node = at_half(morphed("/nodes/0/weights/1", {0}, {1}));
  EXPECT_EQ(node.animations[0].channels.at(0).weight, 1);
  EXPECT_EQ(node.animations[0].channels.at(0).components, 1);
  EXPECT_EQ(load(morphed("/nodes/0/weights/2", {0}, {1})).error,
            "/animations/0/channels/0/target: weight 2 of node 0, whose mesh has 2 morph targets");
  EXPECT_TRUE(load(morphed("/meshes/0/weights/2", {0}, {1})).warned("has no effect"));
}

TEST(AnimationPointer, ReadsIntegersAsFloats) {
  GltfBuilder builder = pointing("/materials/0/extensions/KHR_materials_ior/ior", {1}, {2}, "SCALAR");
  json& output = builder.root["animations"][0]["samplers"][0]["output"];
  output = builder.accessor<uint8_t>({1, 2}, kUnsignedByte, "SCALAR");
  EXPECT_EQ(at_half(builder).materials[0].ior, 1.5f); // an unnormalized integer: 1 is 1.0
  output = builder.accessor<uint8_t>({255, 255}, kUnsignedByte, "SCALAR", true);
  EXPECT_EQ(at_half(builder).materials[0].ior, 1.0f);
}

TEST(AnimationPointer, RefusesValuesOfWrongShape) {
  const auto error = [](const char* type, const std::vector<float>& one) {
    return load(pointing("/materials/0/emissiveFactor", one, one, type)).error;
  };
  EXPECT_NE(error("VEC4", {0, 0, 0, 0}).find("ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_FORMAT"), std::string::npos);
  EXPECT_NE(error("SCALAR", {0}).find("ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_FORMAT"), std::string::npos);
  EXPECT_NE(error("VEC3", {0, 0}).find("values for 2 keys"), std::string::npos);
}

TEST(AnimationPointer, WarnsOnceOfMissingTargets) {
  for (const char* pointer : {"/materials/1/alphaCutoff", "/materials/0/alphaMode", "/materials/0/normalTexture/scale",
                              "/materials/0/emissiveFactor/0", "/extensions/KHR_lights_punctual/lights/0/range",
                              "/cameras/0/perspective/zfar", "/materials//alphaCutoff", "/materials/-1/alphaCutoff",
                              "/materials/99999999999/alphaCutoff", "/meshes/0/weights", "/materials/0", "", "/"}) {
    const Loaded loaded = load(pointing(pointer, {0}, {1}, "SCALAR"));
    ASSERT_TRUE(loaded.scene) << pointer << ": " << loaded.error;
    EXPECT_TRUE(loaded.scene->animations[0].channels.empty()) << pointer;
    EXPECT_EQ(loaded.warnings.size(), 1U) << pointer;
    EXPECT_TRUE(loaded.warned("has no effect")) << pointer;
  }
}

} // namespace
} // namespace kindling::test
