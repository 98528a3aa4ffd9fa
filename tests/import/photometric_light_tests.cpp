// EXT_lights_ies and the parser of IES LM-63.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/lights/parse_ies.h"
#include "renderer/scene/animated_members.h"
#include "renderer/scene/pose.h"
#include "tests/import/gltf_builder.h"

#include <gtest/gtest.h>

namespace kindling::test {
namespace {

using gltf::parse_ies;

// Lines 1 to 5 of a common file.
const std::string kHead = "IESNA:LM-63-2002\r\n"
                          "[TEST] by hand\r\n"
                          "[LAMP] TILT of keywords means nothing\r\n"
                          "TILT=NONE\r\n";
// Candela are 10 * 0.5 times the numbers.
const std::string kTwoPlanes = kHead + "1 1000 10 3 2 1 2 0 0 0\r\n"
                                       "0.5 1 40\r\n"
                                       "0 45 90\r\n"
                                       "0 90\r\n"
                                       "100 80 0\r\n"
                                       "100, 60,\r\n 0\r\n";

TEST(Ies, ReadsAnglesAndScaledCandela) {
  const Result<Photometry> web = parse_ies(kTwoPlanes);
  ASSERT_TRUE(web) << web.error().message;
  EXPECT_EQ(web.value().kind, Photometry::Kind::c);
  EXPECT_EQ(web.value().vertical_deg, (std::vector<float>{0, 45, 90}));
  EXPECT_EQ(web.value().horizontal_deg, (std::vector<float>{0, 90}));
  EXPECT_EQ(web.value().candela, (std::vector<float>{500, 400, 0, 500, 300, 0}));
}

std::string with_numbers(const std::string& first_line, const std::string& tilt, const std::string& lamp_factor) {
  return first_line + "TILT=" + tilt + "\n1 -1 1 2 1 1 1 0 0 0 2 " + lamp_factor + " 40\n0 90\n0\n10 20\n";
}

TEST(Ies, AppliesLampFactorUntil1995) {
  for (const char* version : {"", "IESNA91\n", "IESNA:LM-63-1995\n"})
    EXPECT_EQ(parse_ies(with_numbers(version, "NONE", "1.5")).value().candela, (std::vector<float>{30, 60})) << version;
  for (const char* version : {"IESNA:LM-63-2002\n", "IES:LM-63-2019\n"}) // the factor has another meaning
    EXPECT_EQ(parse_ies(with_numbers(version, "NONE", "1.1")).value().candela, (std::vector<float>{20, 40})) << version;
}

TEST(Ies, NumbersTooSmallForFloatBecomeZero) {
  const std::string tiny = "IESNA91\nTILT=NONE\n1 -1 1 2 1 1 1 0 0 0 1 1 1\n0 90\n0\n10 3.9e-127\n";
  EXPECT_EQ(parse_ies(tiny).value().candela, (std::vector<float>{10, 0}));
}

TEST(Ies, SkipsTilt) {
  const std::string included = "INCLUDE\n1\n3\n0 45 90\n1.0 0.9 0.8";
  EXPECT_EQ(parse_ies(with_numbers("", included, "1")).value().candela, (std::vector<float>{20, 40}));
  EXPECT_EQ(parse_ies(with_numbers("", "lamp.tlt", "1")).value().candela, (std::vector<float>{20, 40}));
}

TEST(Ies, ClosesIncompleteCircles) {
  const Result<Photometry> web = parse_ies(kHead + "1 1 1 1 4 1 1 0 0 0 1 1 1\n90\n0 90 180 270\n1 2 3 4\n");
  ASSERT_TRUE(web) << web.error().message;
  EXPECT_EQ(web.value().horizontal_deg, (std::vector<float>{0, 90, 180, 270, 360}));
  EXPECT_EQ(web.value().candela, (std::vector<float>{1, 2, 3, 4, 1}));
}

TEST(Ies, ReadsTypesAAndB) {
  const auto kind = [](const char* type) {
    return parse_ies(kHead + "1 1 1 2 2 " + type + " 1 0 0 0 1 1 1\n-90 90\n-45 45\n1 2 3 4\n").value().kind;
  };
  EXPECT_EQ(kind("2"), Photometry::Kind::b);
  EXPECT_EQ(kind("3"), Photometry::Kind::a);
}

TEST(Ies, ErrorsNameTheLine) {
  const auto error = [](const std::string& text) {
    const Result<Photometry> web = parse_ies(text);
    return web ? std::string() : web.error().message;
  };
  EXPECT_EQ(error(""), "line 0: no line 'TILT=' before the end, expected a file of IES LM-63");
  EXPECT_EQ(error("IESNA91\nnothing\n"), "line 2: no line 'TILT=' before the end, expected a file of IES LM-63");
  EXPECT_EQ(error(kHead + "1 1 x"), "line 4: 'x' for the candela multiplier, expected a number");
  EXPECT_EQ(error(kHead + "1 1 1\n0"),
            "line 5: 0 for the number of vertical angles, expected a whole number from 1 to 4096");
  EXPECT_EQ(error(kHead + "1 1 1 2 1 4"), "line 4: 4 for the photometric type, expected a whole number from 1 to 3");
  const std::string numbers = kHead + "1 1 1 2 2 1 1 0 0 0 1 1 1\n";
  EXPECT_EQ(error(numbers + "0 0\n"), "line 5: 0 after 0 for a vertical angle, expected increasing angles");
  EXPECT_EQ(error(numbers + "0 190\n0 90\n"), "line 6: vertical angles from 0 to 190, expected 0 to 180 for type C");
  EXPECT_NE(error(numbers + "0 90\n10 90\n").find("horizontal angles from 10 to 90"), std::string::npos);
  EXPECT_NE(error(numbers + "0 90\n0 90\n1").find("the file ends before"), std::string::npos);
  EXPECT_EQ(error(numbers + "0 90\n0 90\n1 -2 3 4"), "line 7: -2 candela, expected a number from 0");
  EXPECT_NE(error(kHead + "1 1 1 4000 4000 1 1 0 0 0 1 1 1\n0\n"), "");
  EXPECT_NE(error(kHead + "1 1 nan"), "");
  EXPECT_NE(error(kHead + "1 1 1e99"), "");
}

// A truncated file is an error or ends in a shorter number; nothing is read past the end
// (sanitizers).
TEST(Ies, SurvivesTruncatedFiles) {
  for (size_t length = 0; length + 6 < kTwoPlanes.size(); ++length) {
    const std::string cut = kTwoPlanes.substr(0, length);
    const auto exact = std::make_unique<char[]>(length + 1);
    std::copy(cut.begin(), cut.end(), exact.get());
    EXPECT_FALSE(parse_ies({exact.get(), length})) << length;
  }
}

GltfBuilder with_luminaire() {
  GltfBuilder builder = triangle();
  builder.root["extensions"]["EXT_lights_ies"]["lights"] =
      json::array({json{{"name", "spot"}, {"uri", data_uri(kTwoPlanes, "application/x-ies-lm-63")}}});
  json node = {{"translation", {1, 2, 3}}};
  node["extensions"]["EXT_lights_ies"] = {{"light", 0}, {"multiplier", 2}, {"color", {1, 0.5, 0.25}}};
  builder.root_node(node);
  return builder;
}

TEST(PhotometricLights, AttachesLightsToNodes) {
  Loaded loaded = load(with_luminaire());
  ASSERT_TRUE(loaded.scene) << loaded.error;
  EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings[0];
  const Scene& scene = *loaded.scene;
  ASSERT_EQ(scene.photometries.size(), 1U);
  EXPECT_EQ(scene.photometries[0].name, "spot");
  ASSERT_EQ(scene.lights.size(), 1U);
  EXPECT_EQ(scene.lights[0].photometry, 0);
  EXPECT_EQ(scene.lights[0].intensity, 2.0f);
  EXPECT_EQ(scene.lights[0].color, Rgb(1, 0.5f, 0.25f));
  const PosedScene posed = pose_scene(scene, {}).value();
  ASSERT_EQ(posed.lights.size(), 1U);
  EXPECT_EQ(posed.lights[0].light_to_world[3][1], 2.0f);
}

TEST(PhotometricLights, AnimatesMultiplierAndColor) {
  GltfBuilder builder = with_luminaire();
  const int input = builder.accessor<float>({0, 1}, kFloat, "SCALAR");
  json target = {{"path", "pointer"}};
  target["extensions"]["KHR_animation_pointer"]["pointer"] = "/nodes/1/extensions/EXT_lights_ies/multiplier";
  const int output = builder.accessor<float>({2, 6}, kFloat, "SCALAR");
  builder.push("animations", {{"channels", json::array({json{{"sampler", 0}, {"target", target}}})},
                              {"samplers", json::array({json{{"input", input}, {"output", output}}})}});
  Loaded loaded = load(builder);
  ASSERT_TRUE(loaded.scene) << loaded.error;
  animate_members(*loaded.scene, 0.25);
  EXPECT_EQ(loaded.scene->lights[0].intensity, 3.0f);
  target["extensions"]["KHR_animation_pointer"]["pointer"] = "/nodes/0/extensions/EXT_lights_ies/multiplier";
  builder.root["animations"][0]["channels"][0]["target"] = target;
  EXPECT_TRUE(load(builder).warned("has no effect"));
}

TEST(PhotometricLights, RefusesInvalidAndDarkensMissingProfiles) {
  GltfBuilder builder = with_luminaire();
  json& profile = builder.root["extensions"]["EXT_lights_ies"]["lights"][0];
  const std::string place = "/extensions/EXT_lights_ies/lights/0";
  profile["uri"] = data_uri("IESNA91\n");
  EXPECT_EQ(load(builder).error, place + ": line 1: no line 'TILT=' before the end, expected a file of IES LM-63");
  profile["uri"] = "missing.ies";
  const Loaded dark = load(builder);
  ASSERT_TRUE(dark.scene) << dark.error;
  EXPECT_TRUE(dark.warned("its lights are dark"));
  EXPECT_EQ(dark.scene->photometries[0].candela, (std::vector<float>{0}));
  profile.erase("uri");
  EXPECT_EQ(load(builder).error, place + ": neither uri nor bufferView, expected one of them (ONE_OF_MISMATCH)");
  profile["bufferView"] = builder.view(kTwoPlanes);
  EXPECT_TRUE(load(builder).scene);
  builder.root["nodes"][1]["extensions"]["EXT_lights_ies"]["light"] = 1;
  EXPECT_EQ(load(builder).error,
            "/nodes/1/extensions/EXT_lights_ies/light: 1, the file has 1 light profiles (UNRESOLVED_REFERENCE)");
}

} // namespace
} // namespace kindling::test
