// The flags for sizes of lights, and the lights that they apply to.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/light_flags.h"
#include "renderer/app/flags/parse_command_line.h"
#include "renderer/facade/light_sizes.h"

#include "renderer/app/options/options.h"
#include "renderer/scene/scene.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace kindling::app {
namespace {

Result<CommandLine> parsed(std::vector<const char*> flags) {
  flags.insert(flags.begin(), {"render", "scene.gltf"});
  return parse_command_line(flags);
}

TEST(LightFlags, ApplyToLightsWithoutASize) {
  const Result<CommandLine> line = parsed({"--light-radius", "0.5", "--sun-angle", "90"});
  ASSERT_TRUE(line.ok());
  Scene scene;
  scene.lights.resize(5);
  scene.lights[1].kind = PunctualLight::Kind::spot;
  scene.lights[2].radius_m = 0.0f;
  scene.lights[3].kind = scene.lights[4].kind = PunctualLight::Kind::directional;
  scene.lights[4].angular_diameter_rad = 0.01f;
  apply_light_options(std::get<RenderOptions>(line.value().command).lights, scene);
  EXPECT_EQ(scene.lights[0].radius_m, 0.5f);
  EXPECT_EQ(scene.lights[1].radius_m, 0.5f);
  EXPECT_EQ(scene.lights[2].radius_m, 0.0f);
  EXPECT_FALSE(scene.lights[3].radius_m);
  EXPECT_FLOAT_EQ(scene.lights[3].angular_diameter_rad.value(), kPi / 2.0f);
  EXPECT_EQ(scene.lights[4].angular_diameter_rad, 0.01f);
  EXPECT_FALSE(scene.lights[0].angular_diameter_rad);

  Scene untouched;
  untouched.lights.resize(1);
  apply_light_options({}, untouched);
  EXPECT_FALSE(untouched.lights[0].radius_m);
}

TEST(LightFlags, RefuseWrongValues) {
  EXPECT_FALSE(parsed({"--light-radius", "-1"}).ok());
  EXPECT_FALSE(parsed({"--light-radius", "inf"}).ok());
  EXPECT_FALSE(parsed({"--sun-angle", "181"}).ok());
}

std::string refusal(std::vector<const char*> flags) {
  const Result<CommandLine> line = parsed(std::move(flags));
  return line.ok() ? std::string() : line.error().message;
}

TEST(StudioFlag, IsOneOfThreeAndExcludesEnvironments) {
  EXPECT_EQ(std::get<RenderOptions>(parsed({}).value().command).studio, Studio::automatic);
  EXPECT_EQ(std::get<RenderOptions>(parsed({"--studio", "off"}).value().command).studio, Studio::off);
  EXPECT_NE(refusal({"--studio", "yes"}).find("use auto, on or off"), std::string::npos)
      << refusal({"--studio", "yes"});
  EXPECT_NE(refusal({"--studio", "on", "--env-color", "1"}).find("give one of them"), std::string::npos);
  EXPECT_EQ(refusal({"--studio", "off", "--env-color", "1"}), "");
}

TEST(ViewFlags, RefuseUnknownValues) {
  EXPECT_EQ(std::get<RenderOptions>(parsed({"--backfaces", "cull"}).value().command).backfaces, Backfaces::cull);
  EXPECT_NE(refusal({"--backfaces", "hide"}).find("use show, cull or auto"), std::string::npos);
  EXPECT_EQ(std::get<RenderOptions>(parsed({"--point-size", "3.5"}).value().command).point_size_px, 3.5);
  EXPECT_EQ(refusal({"--point-size", "0"}), "");
  EXPECT_NE(refusal({"--point-size", "-1"}).find("use 0 to 1000"), std::string::npos);
}

} // namespace
} // namespace kindling::app
