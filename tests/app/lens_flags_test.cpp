// The flags of the lens: their effect on a camera, and refusals.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/lens_flags.h"
#include "renderer/app/flags/parse_command_line.h"
#include "renderer/facade/lens.h"

#include "renderer/app/options/options.h"

#include <gtest/gtest.h>

namespace kindling::test {
namespace {

Result<app::CommandLine> parse_render(std::vector<const char*> flags) {
  flags.insert(flags.begin(), {"render", "scene.gltf"});
  return app::parse_command_line(flags);
}

LensOptions lens_of(const std::vector<const char*>& flags) {
  const Result<app::CommandLine> line = parse_render(flags);
  EXPECT_TRUE(line.ok()) << (line.ok() ? "" : line.error().message);
  return line.ok() ? std::get<app::RenderOptions>(line.value().command).lens : LensOptions{};
}

TEST(LensFlags, OverrideTheLensOfTheCamera) {
  SceneCamera camera;
  camera.lens = {.f_stop = 8.0f, .focus_distance_m = 4.0f, .aperture_blades = 5, .cats_eye = 0.5f};
  const CameraLens before = camera.lens;
  ASSERT_TRUE(override_lens(camera, lens_of({})).ok());
  EXPECT_EQ(camera.lens.f_stop, before.f_stop);
  EXPECT_EQ(camera.lens.focus_distance_m, before.focus_distance_m);
  ASSERT_TRUE(override_lens(camera, lens_of({"--f-stop", "2", "--focal-length", "35", "--aperture-blades", "7",
                                             "--aperture-rotation", "180", "--anamorphic", "2", "--cats-eye", "0.25",
                                             "--focus-pixel", "3,4"}))
                  .ok());
  EXPECT_EQ(camera.lens.f_stop, 2.0f);
  EXPECT_EQ(camera.lens.focal_length_m, 0.035f);
  EXPECT_FALSE(camera.lens.focus_distance_m); // replaced by the pixel
  EXPECT_EQ(camera.lens.aperture_blades, 7);
  EXPECT_EQ(camera.lens.aperture_rotation_rad, kPi);
  EXPECT_EQ(camera.lens.anamorphic_ratio, 2.0f);
  EXPECT_EQ(camera.lens.cats_eye, 0.25f);
  ASSERT_TRUE(override_lens(camera, lens_of({"--f-stop", "none"})).ok());
  EXPECT_TRUE(camera.lens.is_pinhole());
}

TEST(LensFlags, RefuseWrongCombinations) {
  const auto message = [](const std::vector<const char*>& flags) {
    const Result<app::CommandLine> line = parse_render(flags);
    return line.ok() ? std::string() : line.error().message;
  };
  EXPECT_EQ(message({"--focus-distance", "2", "--focus-pixel", "1,2"}),
            "--focus-distance and --focus-pixel: give one of them");
  EXPECT_EQ(message({"--f-stop", "none", "--cats-eye", "0.5"}), "--cats-eye: has no meaning with --f-stop none");
  EXPECT_EQ(message({"--f-stop", "wide"}).substr(0, 10), "--f-stop: ");
  EXPECT_EQ(message({"--f-stop", "0"}).substr(0, 10), "--f-stop: ");
  const auto refused = [](SceneCamera camera, const std::vector<const char*>& flags) {
    const Result<void> overridden = override_lens(camera, lens_of(flags));
    return overridden.ok() ? std::string() : overridden.error().message;
  };
  EXPECT_EQ(refused({}, {"--focal-length", "50"}), "--focal-length: the camera is a pinhole; give --f-stop as well");
  EXPECT_EQ(refused({}, {"--f-stop", "2", "--aperture-blades", "2"}),
            "--aperture-blades: 2 blades leave no opening; use 0 or 3 to 64");
  SceneCamera flat;
  flat.kind = SceneCamera::Kind::orthographic;
  EXPECT_EQ(refused(flat, {"--f-stop", "2"}), "--f-stop: the camera is orthographic; give --focal-length as well");
  EXPECT_EQ(refused(flat, {"--f-stop", "2", "--focal-length", "50"}), "");
}

} // namespace
} // namespace kindling::test
