// Extras of lights and shadow catchers that are valid, invalid or of another kind.
// SPDX-License-Identifier: Apache-2.0
#include "tests/import/gltf_builder.h"

#include <gtest/gtest.h>

namespace kindling::test {
namespace {

Loaded with_extras_light(std::string_view light) {
  GltfBuilder builder;
  builder.root["extensionsUsed"] = {"KHR_lights_punctual"};
  builder.root["extensions"]["KHR_lights_punctual"]["lights"] = json::array({json::parse(light)});
  builder.root_node({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  return load(builder);
}

TEST(LightExtras, ReadsAllKeys) {
  const Loaded point = with_extras_light(R"({"type": "point", "extras": {"kindling": {"radius": 0.25}}})");
  ASSERT_TRUE(point.scene) << point.error;
  EXPECT_TRUE(point.warnings.empty());
  EXPECT_EQ(point.scene->lights[0].radius_m, 0.25f);
  const Loaded spot = with_extras_light(R"({"type": "spot", "spot": {}, "extras": {"kindling": {"radius": 0}}})");
  EXPECT_EQ(spot.scene->lights[0].radius_m, 0.0f); // set by the file, so no flag changes it
  const Loaded sun =
      with_extras_light(R"({"type": "directional", "extras": {"kindling": {"angularDiameter": 0.0093}}})");
  EXPECT_EQ(sun.scene->lights[0].angular_diameter_rad, 0.0093f);
  EXPECT_TRUE(sun.warnings.empty());
  const Loaded plain = with_extras_light(R"({"type": "point"})");
  EXPECT_FALSE(plain.scene->lights[0].radius_m);
  EXPECT_FALSE(plain.scene->lights[0].angular_diameter_rad);
}

TEST(LightExtras, LightGroupsOfLightsMaterialsAndNodes) {
  GltfBuilder builder;
  builder.root["extensionsUsed"] = {"KHR_lights_punctual"};
  builder.root["extensions"]["KHR_lights_punctual"]["lights"] =
      json::parse(R"([{"type": "point", "extras": {"kindling": {"lightGroup": "key"}}}, {"type": "point"}])");
  builder.root["materials"] = json::parse(
      R"([{"extras": {"kindling": {"lightGroup": "screen"}}}, {"extras": {"kindling": {"lightGroup": 7}}}])");
  builder.root_node({{"extras", {{"kindling", {{"lightGroup", "room"}}}, {"other", 1}}}});
  builder.root_node({{"extras", {{"kindling", {{"lightGroup", ""}, {"group", "x"}}}}}});
  const Loaded loaded = load(builder);
  ASSERT_TRUE(loaded.scene) << loaded.error;
  EXPECT_EQ(loaded.scene->lights[0].light_group, "key");
  EXPECT_EQ(loaded.scene->lights[1].light_group, "");
  EXPECT_EQ(loaded.scene->materials[0].light_group, "screen");
  EXPECT_EQ(loaded.scene->materials[1].light_group, "");
  EXPECT_EQ(loaded.scene->nodes[0].light_group, "room");
  EXPECT_EQ(loaded.scene->nodes[1].light_group, "");
  EXPECT_TRUE(loaded.warned("/materials/1/extras/kindling/lightGroup"));
  EXPECT_TRUE(loaded.warned("'group' is ignored, expected one of lightGroup"));
  EXPECT_EQ(loaded.warnings.size(), 2U); // that of the node counts with that of the material
}

TEST(ShadowCatcherExtras, MarkNodesAndMaterials) {
  GltfBuilder builder;
  builder.root["materials"] = json::parse(
      R"([{"extras": {"kindling": {"shadowCatcher": true}}}, {"extras": {"kindling": {"shadowCatcher": false}}}, {}])");
  builder.root_node({{"extras", {{"kindling", {{"shadowCatcher", true}, {"lightGroup", "room"}}}}}});
  builder.root_node({{"extras", {{"shadowCatcher", true}}}}); // of another application
  const Loaded loaded = load(builder);
  ASSERT_TRUE(loaded.scene) << loaded.error;
  EXPECT_TRUE(loaded.warnings.empty());
  EXPECT_TRUE(loaded.scene->materials[0].shadow_catcher);
  EXPECT_FALSE(loaded.scene->materials[1].shadow_catcher);
  EXPECT_FALSE(loaded.scene->materials[2].shadow_catcher);
  EXPECT_TRUE(loaded.scene->nodes[0].shadow_catcher);
  EXPECT_FALSE(loaded.scene->nodes[1].shadow_catcher);
}

TEST(ShadowCatcherExtras, WarnsOfIgnoredValues) {
  for (const char* value : {"1", R"("yes")", "null", "[true]"}) {
    GltfBuilder builder;
    builder.root["materials"] =
        json::parse(std::string(R"([{"extras": {"kindling": {"shadowCatcher": )") + value + "}}}]");
    builder.root_node({{"extras", {{"kindling", {{"shadowCatcher", json::parse(value)}}}}}});
    const Loaded loaded = load(builder);
    ASSERT_TRUE(loaded.scene) << loaded.error;
    EXPECT_FALSE(loaded.scene->materials[0].shadow_catcher) << value;
    EXPECT_FALSE(loaded.scene->nodes[0].shadow_catcher) << value;
    EXPECT_TRUE(loaded.warned("/materials/0/extras/kindling/shadowCatcher")) << value;
    EXPECT_TRUE(loaded.warned("is ignored, expected true or false")) << value;
  }
}

TEST(LightExtras, WarnsOfIgnoredValues) {
  struct BrokenLight {
    const char* type;
    const char* own;
    const char* warning;
  };
  for (const BrokenLight& broken : {
           BrokenLight{"point", R"({"radius": -1})",
                       "radius: '-1' is ignored, expected a length from 0 to 1e9, in meters"},
           BrokenLight{"point", R"({"radius": "wide"})", R"(radius: '"wide"' is ignored)"},
           BrokenLight{"point", R"({"angularDiameter": 0.1})",
                       "'angularDiameter' is ignored, expected one of radius, lightGroup"},
           BrokenLight{"directional", R"({"angularDiameter": 4})",
                       "angularDiameter: '4' is ignored, expected an angle"},
           BrokenLight{"directional", R"({"radius": 1})",
                       "'radius' is ignored, expected one of angularDiameter, lightGroup"},
       }) {
    const Loaded loaded = with_extras_light(std::string(R"({"type": ")") + broken.type +
                                            R"(", "extras": {"kindling": )" + broken.own + "}}");
    ASSERT_TRUE(loaded.scene) << loaded.error;
    EXPECT_TRUE(loaded.warned("/extensions/KHR_lights_punctual/lights/0/extras/kindling"));
    EXPECT_TRUE(loaded.warned(broken.warning)) << (loaded.warnings.empty() ? "no warning" : loaded.warnings[0]);
    EXPECT_EQ(loaded.warnings.size(), 1U);
    EXPECT_FALSE(loaded.scene->lights[0].radius_m);
    EXPECT_FALSE(loaded.scene->lights[0].angular_diameter_rad);
  }
}

} // namespace
} // namespace kindling::test
