// KHR_materials_variants: mappings and their application.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/variants.h"
#include "tests/import/gltf_builder.h"

#include <gtest/gtest.h>

namespace kindling::test {
namespace {

// Returns a triangle with three materials and two variants.
GltfBuilder with_mappings(const char* mappings) {
  GltfBuilder builder = triangle();
  builder.root["extensions"]["KHR_materials_variants"]["variants"] =
      json::parse(R"([{"name": "red"}, {"name": "blue"}])");
  for (const char* name : {"plain", "red paint", "blue paint"}) builder.push("materials", {{"name", name}});
  json& primitive = builder.root["meshes"][0]["primitives"][0];
  primitive["material"] = 0;
  primitive["extensions"]["KHR_materials_variants"]["mappings"] = json::parse(mappings);
  return builder;
}

int material_in(const Loaded& loaded, int variant) {
  Scene scene = *loaded.scene;
  apply_variant(scene, variant);
  return scene.meshes[0].primitives[0].material;
}

TEST(Variants, MappingsSetMaterialOfPrimitive) {
  const Loaded loaded = load(with_mappings(R"([{"material": 2, "variants": [1], "name": "any"}])"));
  ASSERT_TRUE(loaded.scene) << loaded.error;
  EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings[0];
  EXPECT_EQ(loaded.scene->variants, (std::vector<std::string>{"red", "blue"}));
  EXPECT_EQ(loaded.scene->meshes[0].primitives[0].material, 0);
  EXPECT_EQ(material_in(loaded, 1), 2);
  EXPECT_EQ(material_in(loaded, 0), 0) << "the file has no variant red";
}

TEST(Variants, OneMappingAppliesToSeveralVariants) {
  const Loaded loaded = load(with_mappings(R"([{"material": 1, "variants": [0, 1]}])"));
  EXPECT_EQ(material_in(loaded, 0), 1);
  EXPECT_EQ(material_in(loaded, 1), 1);
}

TEST(Variants, RefusesOrSkipsInvalidMappings) {
  EXPECT_EQ(load(with_mappings(R"([{"material": 3, "variants": [0]}])")).error,
            "/meshes/0/primitives/0/extensions/KHR_materials_variants/mappings/0/material: 3, expected an index of "
            "materials, 0 to 2 (UNRESOLVED_REFERENCE)");
  EXPECT_NE(load(with_mappings(R"([{"variants": [0]}])")).error.find("'material' is missing"), std::string::npos);
  EXPECT_NE(load(with_mappings(R"([{"material": 1}])")).error.find("'variants' is missing"), std::string::npos);
  EXPECT_NE(load(with_mappings(R"([{"material": 1, "variants": [0.5]}])")).error.find("an integer"), std::string::npos);

  const Loaded nowhere = load(with_mappings(R"([{"material": 1, "variants": [2, 0]}])"));
  ASSERT_TRUE(nowhere.scene) << nowhere.error;
  EXPECT_TRUE(nowhere.warned("/mappings/0/variants/0: 2 is not one of the 2 variants (UNRESOLVED_REFERENCE)"));
  EXPECT_EQ(material_in(nowhere, 0), 1);

  const Loaded twice = load(with_mappings(R"([{"material": 1, "variants": [0]}, {"material": 2, "variants": [0]}])"));
  ASSERT_TRUE(twice.scene) << twice.error;
  EXPECT_TRUE(twice.warned("KHR_MATERIALS_VARIANTS_NON_UNIQUE_VARIANT"));
  EXPECT_EQ(material_in(twice, 0), 1) << "the first counts";
}

TEST(Variants, ComputesTangentsForVariantMaterials) {
  GltfBuilder builder = with_mappings(R"([{"material": 2, "variants": [1]}])");
  builder.root["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] =
      builder.accessor<float>({0, 0, 1, 0, 0, 1}, kFloat, "VEC2");
  builder.root["materials"][2]["normalTexture"] = {{"index", 0}};
  builder.push("textures", {{"source", 0}});
  builder.push("images", {{"uri", "data:image/png;base64," + std::string(kPngBase64)}});
  const Loaded loaded = load(builder);
  ASSERT_TRUE(loaded.scene) << loaded.error;
  EXPECT_EQ(loaded.scene->meshes[0].primitives[0].tangents.size(), 3U);
}

} // namespace
} // namespace kindling::test
