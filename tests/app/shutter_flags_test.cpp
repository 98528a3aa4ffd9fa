// The shutter from flags and from cameras.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/shutter_flags.h"
#include "renderer/facade/shutter.h"

#include "renderer/app/options/options.h"
#include "tests/app/render_line.h"

#include <gtest/gtest.h>

namespace kindling::app {
namespace {

std::optional<Shutter> shutter_of(const Scene& scene, std::vector<const char*> flags) {
  return choose_shutter(scene, kNone, options_of(std::move(flags))).value();
}

// A scene of two cameras, the second with a shutter.
Scene with_cameras() {
  Scene scene;
  scene.cameras.resize(2);
  scene.cameras[1].shutter = Shutter{-0.01, 0.02};
  scene.nodes.resize(2);
  scene.nodes[0].camera = 0;
  scene.nodes[1].camera = 1;
  scene.nodes[1].name = "Moving";
  return scene;
}

TEST(ShutterFlags, AreRelativeToTheTime) {
  std::optional<Shutter> shutter = shutter_of({}, {"--shutter", "-0.5,0.25", "--time", "2"});
  ASSERT_TRUE(shutter);
  EXPECT_EQ(shutter->open_s, 1.5);
  EXPECT_EQ(shutter->close_s, 2.25);
  EXPECT_EQ(*time_of_image(shutter, {}), 1.875);
  shutter = shutter_of({}, {"--shutter", "0.1,0.1"});
  ASSERT_TRUE(shutter);
  EXPECT_EQ(shutter->open_s, 0.1);
  EXPECT_EQ(shutter->close_s, 0.1);
  shutter = shutter_of({}, {"--shutter-angle", "180", "--fps", "25", "--time", "1"});
  ASSERT_TRUE(shutter);
  EXPECT_EQ(shutter->open_s, 1.0);
  EXPECT_DOUBLE_EQ(shutter->close_s, 1.02);
}

TEST(ShutterFlags, DefaultIsNoShutter) {
  EXPECT_FALSE(shutter_of({}, {}));
  EXPECT_FALSE(shutter_of({}, {"--time", "3"}));
  EXPECT_FALSE(time_of_image(std::nullopt, {}));
  RenderOptions options;
  options.time_s = 3.0;
  EXPECT_EQ(*time_of_image(std::nullopt, options), 3.0);
}

TEST(ShutterFlags, OverrideTheShutterOfTheCamera) {
  EXPECT_FALSE(shutter_of(with_cameras(), {}));
  EXPECT_FALSE(shutter_of(with_cameras(), {"--orbit", "0,90,3"}));
  const std::optional<Shutter> own = shutter_of(with_cameras(), {"--camera", "Moving", "--time", "1"});
  ASSERT_TRUE(own);
  EXPECT_EQ(own->open_s, 0.99);
  EXPECT_EQ(own->close_s, 1.02);
  EXPECT_EQ(shutter_of(with_cameras(), {"--camera", "Moving", "--shutter", "0,7"})->close_s, 7.0);
  EXPECT_FALSE(choose_shutter(with_cameras(), kNone, options_of({"--camera", "Missing"})).ok());
}

TEST(ShutterFlags, RefuseWrongValues) {
  EXPECT_EQ(refusal({"--shutter", "0.2,0.1"}),
            "--shutter: closes at 0.1 s, before it opens at 0.2 s; use OPEN,CLOSE in this order");
  for (const char* text : {"1", "0,1,2", "0,x", "", ",", "0,inf"})
    EXPECT_EQ(refusal({"--shutter", text}),
              "--shutter: '" + std::string(text) + "' is not an interval; use OPEN,CLOSE in seconds, such as 0,0.02");
  EXPECT_NE(refusal({"--shutter-angle", "-10", "--fps", "24"}).find("--shutter-angle: "), std::string::npos);
  EXPECT_NE(refusal({"--shutter-angle", "361", "--fps", "24"}).find("--shutter-angle: "), std::string::npos);
  EXPECT_NE(refusal({"--shutter-angle", "180", "--fps", "0"}).find("--fps: "), std::string::npos);
  EXPECT_EQ(refusal({"--fps", "24"}),
            "--fps: has no meaning without --shutter-angle, --frames, --turntable or --aov vector or motion");
  EXPECT_EQ(refusal({"--shutter-angle", "180"}), "--shutter-angle: needs --fps, the frames per second");
  EXPECT_EQ(refusal({"--shutter", "0,1", "--shutter-angle", "180", "--fps", "24"}),
            "--shutter and --shutter-angle: give one of them");
}

} // namespace
} // namespace kindling::app
