// Motion blur on the command line, with the animations of the repository.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decode_image.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <nlohmann/json.hpp>

namespace kindling::test {
namespace {

class ShutterCommand : public SceneFolder {
 protected:
  // The image, to the bit.
  [[nodiscard]] std::vector<std::byte> render(const std::string& scene, std::vector<std::string> flags) const {
    flags.insert(flags.begin(), {"render", KINDLING_SCENES "/tiny/" + scene, "--size", "16x16", "--spp", "4",
                                 "--exr-float", "-o", "a.exr", "--stats", "s.json", "-v", "--progress", "none"});
    const ProgramResult result = run_program(flags, folder_);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    err_ = result.err;
    Result<Image> image = read_image_file(folder_ / "a.exr");
    return image.ok() ? image.value().pixels : std::vector<std::byte>();
  }
  [[nodiscard]] nlohmann::json shutter() const { return nlohmann::json::parse(read_file("s.json"))["shutter"]; }
  mutable std::string err_;
};

TEST_F(ShutterCommand, MotionNeedsAShutter) {
  (void)render("animation.gltf", {"--time", "0.25"});
  EXPECT_TRUE(shutter().is_null());
  (void)render("animation.gltf", {"--time", "0.25", "--shutter", "0,0.5"});
  EXPECT_EQ(shutter()["open_s"], 0.25);
  EXPECT_EQ(shutter()["close_s"], 0.75);
  EXPECT_GE(shutter()["moving_instances"], 3);
  EXPECT_EQ(shutter()["deforming_meshes"], 0);
  EXPECT_GE(shutter()["max_keys"], 3);
  EXPECT_NE(err_.find("motion: "), std::string::npos) << err_;
  (void)render("morph_targets.gltf", {"--shutter-angle", "360", "--fps", "2"});
  EXPECT_EQ(shutter()["close_s"], 0.5);
  EXPECT_EQ(shutter()["deforming_meshes"], 1);
}

TEST_F(ShutterCommand, InstantShutterEqualsPose) {
  const std::vector<std::byte> still = render("animation.gltf", {"--time", "0.25"});
  EXPECT_FALSE(still.empty());
  EXPECT_TRUE(render("animation.gltf", {"--time", "0.25", "--shutter", "0,0"}) == still);
  EXPECT_FALSE(render("animation.gltf", {"--time", "0.25", "--shutter", "0,0.5"}) == still);
}

} // namespace
} // namespace kindling::test
