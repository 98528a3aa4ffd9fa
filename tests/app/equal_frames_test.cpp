// Frames of an animation in which nothing moves are reported before they are rendered.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/output/equal_frames.h"
#include "renderer/camera/camera.h"
#include "tests/app/render_line.h"

namespace kindling::app {
namespace {

// One channel of two keys, at 1 s and 2 s.
Scene animated_scene(const std::vector<float>& values) {
  Scene scene;
  scene.source = "a.glb";
  scene.nodes.resize(1);
  AnimationChannel channel;
  channel.node = 0;
  channel.times_s = {1.0f, 2.0f};
  channel.values = values;
  scene.animations.push_back({"move", {channel}});
  return scene;
}

std::string warning(const Scene& scene, std::vector<const char*> flags) {
  return equal_frames_warning(scene, kNone, options_of(std::move(flags)));
}

TEST(EqualFrames, WarnsIfNothingIsAnimated) {
  Scene scene;
  scene.source = "a.glb";
  EXPECT_EQ(
      warning(scene, {"--orbit", "30,60,3", "--frames", "0-3"}),
      "--frames: all 4 frames are equal: nothing in a.glb is animated; only animations of the file move things from "
      "frame to frame, --orbit does not; --turntable and --camera-path move the camera");
  EXPECT_TRUE(warning(scene, {"--frames", "7"}).empty()); // one frame
  EXPECT_TRUE(warning(scene, {}).empty());
  EXPECT_FALSE(warning(animated_scene({1, 2, 3, 1, 2, 3}), {"--frames", "0-48"}).empty()); // equal keys
}

TEST(EqualFrames, AcceptsFramesThatMove) {
  const Scene scene = animated_scene({1, 2, 3, 1, 2, 4});
  EXPECT_EQ(warning(scene, {"--frames", "0-48"}), "");
  EXPECT_EQ(warning(scene, {"--frames", "0-25"}), ""); // the last frame is beyond the first key
  Scene spline = animated_scene({1, 1, 1, 0, 0, 0, 1, 1, 1, 1, 1, 1, 0, 0, 0, 1, 1, 1});
  spline.animations[0].channels[0].interpolation = Interpolation::cubic_spline;
  EXPECT_EQ(warning(spline, {"--frames", "0-48"}), ""); // tangents move it
}

TEST(EqualFrames, WarnsOutsideOfTheKeys) {
  const Scene scene = animated_scene({1, 2, 3, 1, 2, 4});
  EXPECT_EQ(
      warning(scene, {"--frames", "48-72"}),
      "--frames: all 25 frames are equal: they show 2 s to 3 s, and the animations of a.glb run from 1 s to 2 s; use "
      "other frames, or another --fps or --time");
  EXPECT_FALSE(warning(scene, {"--frames", "0-24"}).empty());
  EXPECT_EQ(warning(scene, {"--frames", "0-24", "--shutter", "0,0.1"}), ""); // open beyond the first key
  EXPECT_EQ(warning(scene, {"--frames", "0-24", "--time", "0.5"}), "");
}

} // namespace
} // namespace kindling::app
