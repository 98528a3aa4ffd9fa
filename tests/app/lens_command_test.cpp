// Renders with a lens: focus, metadata, refusals.
// SPDX-License-Identifier: Apache-2.0
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

namespace kindling::test {
namespace {

class LensCommand : public SceneFolder {
 protected:
  [[nodiscard]] ProgramResult render(std::vector<std::string> flags) const {
    std::vector<std::string> arguments{"render", write_scene(), "--spp", "1", "--size", "16x16", "-v"};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    return run_program(arguments, folder_);
  }
};

// Writes OpenEXR's standard attributes of lenses.
TEST_F(LensCommand, WritesMetadata) {
  ASSERT_EQ(render({"--f-stop", "2", "-o", "lens.exr"}).exit_code, 0);
  const std::string exr = read_file("lens.exr");
  EXPECT_NE(exr.find(std::string("aperture\0float", 14)), std::string::npos);
  EXPECT_NE(exr.find(std::string("focus\0float", 11)), std::string::npos);
  ASSERT_EQ(render({"-o", "pinhole.exr"}).exit_code, 0);
  EXPECT_EQ(read_file("pinhole.exr").find("aperture"), std::string::npos);
}

// The square of the scene is 2 m in front of its camera.
TEST_F(LensCommand, FocusesOnTheVisibleSurface) {
  for (const std::vector<std::string>& flags :
       {std::vector<std::string>{"--f-stop", "2"}, {"--f-stop", "2", "--focus-pixel", "8,8"}}) {
    const ProgramResult result = render(flags);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_NE(result.err.find("in focus: 2 m along the axis\n"), std::string::npos) << result.err;
  }
  const ProgramResult nothing = render({"--f-stop", "2", "--focus-pixel", "0,0", "--fov", "120"});
  EXPECT_EQ(nothing.exit_code, 2);
  EXPECT_NE(nothing.err.find("--focus-pixel: no surface is seen at 0,0"), std::string::npos) << nothing.err;
  const ProgramResult outside = render({"--f-stop", "2", "--focus-pixel", "16,0"});
  EXPECT_EQ(outside.exit_code, 2);
  EXPECT_NE(outside.err.find("--focus-pixel: 16,0 is not inside the image; use 0,0 to 15,15"), std::string::npos);
}

} // namespace
} // namespace kindling::test
