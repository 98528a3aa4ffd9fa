// `kindling render --turntable`, `--camera-path`, and videos of frames.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decode_image.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>

namespace kindling::test {
namespace {

using Words = std::vector<std::string>;

class TurntableCommand : public SceneFolder {
 protected:
  void SetUp() override {
    SceneFolder::SetUp();
    write_scene();
    use_ffmpeg("");
  }
  void TearDown() override {
    unsetenv("KINDLING_FFMPEG");
    SceneFolder::TearDown();
  }
  static void use_ffmpeg(const std::string& file) { ASSERT_EQ(setenv("KINDLING_FFMPEG", file.c_str(), 1), 0); }
  // A stand-in for ffmpeg, which runs this shell code.
  void write_ffmpeg(const std::string& code) {
    write_file("ffmpeg.sh", "#!/bin/sh\nfor last; do :; done\nlast=${last#file:}\n" + code);
    std::filesystem::permissions(folder_ / "ffmpeg.sh", std::filesystem::perms::owner_all);
    use_ffmpeg((folder_ / "ffmpeg.sh").string());
  }

  [[nodiscard]] ProgramResult render(const Words& more) const {
    Words words{"render", "scene.gltf", "--size", "24x16", "--spp", "2", "--progress", "none"};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(words, folder_);
  }
  void expect_done(const Words& more) const {
    const ProgramResult result = render(more);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  }
  void expect_refused(const Words& more, const std::string& why) const {
    const ProgramResult result = render(more);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_NE(result.err.find(why), std::string::npos) << result.err;
  }
  [[nodiscard]] std::vector<std::byte> pixels(const std::string& name) const {
    Result<Image> image = read_image_file(folder_ / name);
    EXPECT_TRUE(image.ok()) << (image.ok() ? "" : image.error().message);
    return image.ok() ? image.value().pixels : std::vector<std::byte>();
  }
  // Two 8-bit images agree but for rounding: cameras that are placed by different formulas.
  void expect_similar(const std::string& name, const std::string& other) const {
    const std::vector<std::byte> a = pixels(name), b = pixels(other);
    ASSERT_EQ(a.size(), b.size());
    size_t different = 0;
    for (size_t i = 0; i < a.size(); ++i)
      different += std::abs(std::to_integer<int>(a[i]) - std::to_integer<int>(b[i])) > 2 ? 1 : 0;
    EXPECT_LE(different, a.size() / 50) << name << ", " << other;
  }
};

TEST_F(TurntableCommand, FramesEqualSingleRenders) {
  for (const Words& camera : {Words{}, Words{"--orbit", "20,60,4", "--orbit-axis", "1,1,0"},
                              Words{"--target", "0.1,0.2,0.3", "--orbit-axis", "z"}}) {
    SCOPED_TRACE(fmt::format("{}", fmt::join(camera, " ")));
    Words all = camera;
    all.insert(all.end(), {"--turntable", "4", "--force", "-o", "t_#.exr"});
    expect_done(all);
    for (const int frame : {0, 1, 3}) {
      Words one = camera;
      one.insert(one.end(), {"--turn", fmt::format("{}", 90 * frame), "-o", "single.exr"});
      expect_done(one);
      EXPECT_EQ(pixels(fmt::format("t_{}.exr", frame)), pixels("single.exr")) << frame;
    }
    EXPECT_NE(pixels("t_0.exr"), pixels("t_1.exr")) << "nothing turns, so nothing is tested";
  }
  expect_done({"-o", "unturned.exr"});
  expect_done({"--turn", "0", "-o", "zero.exr"});
  EXPECT_EQ(pixels("unturned.exr"), pixels("zero.exr"));
}

// An orbit that turns about y is the orbit with another azimuth.
TEST_F(TurntableCommand, TurnsAsAnOrbitDoes) {
  expect_done({"--orbit", "0,70,4", "--turn", "90", "--integrator", "normal", "-o", "turned.png"});
  expect_done({"--orbit", "90,70,4", "--integrator", "normal", "-o", "orbit.png"});
  expect_similar("turned.png", "orbit.png");
  expect_done({"--orbit", "0,70,4", "--integrator", "normal", "-o", "unturned.png"});
  EXPECT_NE(pixels("unturned.png"), pixels("turned.png"));
}

TEST_F(TurntableCommand, TimesAndPartsOfATurn) {
  expect_done({"--turntable", "0.5s", "--fps", "8", "--frames", "1,3", "-o", "t_#.png"});
  EXPECT_FALSE(exists("t_0.png"));
  EXPECT_TRUE(exists("t_1.png") && exists("t_3.png"));
  expect_refused({"--turntable", "4", "--frames", "4", "-o", "t_#.png"}, "4 is no frame of the turntable; use 0 to 3");
  expect_refused({"--turntable", "4", "--turn", "5", "-o", "t_#.png"}, "--turn and --turntable");
  expect_refused({"--turntable", "0", "-o", "t_#.png"}, "--turntable");
  expect_refused({"--orbit-axis", "z"}, "--orbit-axis: has no meaning");
  expect_refused({"--turn", "3", "--orbit-axis", "0,0,0"}, "no direction");
  expect_refused({"--turntable", "4", "-o", "same.png"}, "all frames would have this name");
}

TEST_F(TurntableCommand, VideosGetTheFramesThroughAPipe) {
  write_ffmpeg("echo \"$@\" > arguments.txt\ncat > \"$last\"\n");
  expect_done({"--turntable", "3", "-o", "spin.mp4", "-o", "t_#.png", "--fps", "12"});
  const std::string video = read_file("spin.mp4");
  constexpr size_t kFrame = 24 * 16 * 3;
  ASSERT_EQ(video.size(), 3 * kFrame);
  for (const size_t frame : {0U, 1U, 2U}) {
    const std::vector<std::byte> rgba = pixels(fmt::format("t_{}.png", frame));
    const size_t channels = rgba.size() / (24 * 16);
    size_t different = 0;
    for (size_t i = 0; i < 24 * 16; ++i) {
      if (channels == 4 && rgba[i * 4 + 3] != std::byte{255}) continue;
      for (size_t c = 0; c < 3; ++c)
        different += std::byte{static_cast<unsigned char>(video[frame * kFrame + 3 * i + c])} != rgba[i * channels + c];
    }
    EXPECT_EQ(different, 0U) << frame;
  }
  const std::string arguments = read_file("arguments.txt");
  for (const char* word : {"-s 24x16", "-r 12", "rgb24", "libx264", "pipe:0"})
    EXPECT_NE(arguments.find(word), std::string::npos) << word << " in " << arguments;
  // Existing images do not keep a video from being made.
  expect_done({"--turntable", "3", "-o", "again.gif", "-o", "t_#.png", "--fps", "12"});
  EXPECT_EQ(read_file("again.gif"), video);
  // A video alone leaves no images.
  std::filesystem::remove(folder_ / "t_0.png");
  expect_done({"--turntable", "3", "-o", "alone.webm"});
  EXPECT_EQ(read_file("alone.webm"), video);
  EXPECT_FALSE(exists("scene-0000.png"));
}

// Frames whose images exist and are whole are not rendered again for a video.
TEST_F(TurntableCommand, VideosTakeTheFramesThatExist) {
  write_ffmpeg("cat > \"$last\"\n");
  const Words words{"--turntable", "3", "-o", "spin.mp4", "-o", "t_#.png"};
  expect_done(words);
  const std::string video = read_file("spin.mp4");
  std::filesystem::remove(folder_ / "t_1.png");
  const ProgramResult resumed = render(words);
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_NE(resumed.err.find("skipped 2 frames that were there: 0, 2"), std::string::npos) << resumed.err;
  EXPECT_EQ(read_file("spin.mp4"), video);
  EXPECT_TRUE(exists("t_1.png"));
  // The frames come from the files: one that is another image gets into the video.
  std::filesystem::copy_file(folder_ / "t_2.png", folder_ / "t_0.png",
                             std::filesystem::copy_options::overwrite_existing);
  expect_done(words);
  const size_t frame = video.size() / 3;
  EXPECT_EQ(read_file("spin.mp4"), video.substr(2 * frame) + video.substr(frame));
  // What is damaged, or not the image of the video, is rendered again.
  write_file("t_0.png", read_file("t_0.png").substr(0, 200));
  expect_done(words);
  EXPECT_EQ(read_file("spin.mp4"), video);
  const Words clear{"--turntable", "3", "--background", "transparent", "-o", "clear.mp4", "-o", "c_#.png"};
  expect_done(clear);
  const ProgramResult again = render(clear);
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(again.err.find("skipped"), std::string::npos) << again.err;
  // Another size is noticed.
  Words larger = words;
  larger.insert(larger.end(), {"--size", "32x16"});
  std::filesystem::remove(folder_ / "t_2.png");
  const ProgramResult different = render(larger);
  EXPECT_EQ(different.exit_code, 4) << different.err;
  EXPECT_NE(different.err.find("a frame has 32x16 pixels, the first one 24x16"), std::string::npos) << different.err;
  EXPECT_EQ(read_file("spin.mp4"), video);
}

TEST_F(TurntableCommand, AnimationsAdvanceWhereAsked) {
  const auto turn = [&](const Words& more) {
    Words words{"render", KINDLING_SCENES "/tiny/animation.gltf", "--size", "24x16", "--spp", "2", "--progress",
                "none"};
    words.insert(words.end(), more.begin(), more.end());
    const ProgramResult result = run_program(words, folder_);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  };
  turn({"--turntable", "4", "--turntable-animated", "--fps", "8", "--time", "0.25", "-o", "a_#.exr"});
  turn({"--turntable", "4", "--time", "0.25", "-o", "s_#.exr"});
  turn({"--turn", "180", "--time", "0.5", "-o", "moved.exr"});
  turn({"--turn", "180", "--time", "0.25", "-o", "still.exr"});
  EXPECT_EQ(pixels("a_2.exr"), pixels("moved.exr"));
  EXPECT_EQ(pixels("s_2.exr"), pixels("still.exr"));
  EXPECT_NE(pixels("a_2.exr"), pixels("s_2.exr"));
  EXPECT_EQ(pixels("a_0.exr"), pixels("s_0.exr"));
  expect_refused({"--turntable-animated"}, "--turntable-animated: has no meaning without --turntable");
}

TEST_F(TurntableCommand, FailuresOfFfmpegAreReported) {
  write_file("spin.mp4", "before");
  write_ffmpeg("cat > /dev/null\necho 'some notice' >&2\necho 'Unknown encoder' >&2\nexit 1\n");
  ProgramResult result = render({"--turntable", "2", "-o", "spin.mp4"});
  EXPECT_EQ(result.exit_code, 4) << result.err;
  EXPECT_NE(result.err.find("spin.mp4: ffmpeg failed: Unknown encoder"), std::string::npos) << result.err;
  write_ffmpeg("exit 3\n"); // takes no frame
  result = render({"--turntable", "200", "--integrator", "normal", "--spp", "1", "-o", "spin.mp4"});
  EXPECT_EQ(result.exit_code, 4) << result.err;
  EXPECT_NE(result.err.find("ffmpeg"), std::string::npos) << result.err;
  use_ffmpeg("/nowhere/ffmpeg");
  result = render({"--turntable", "2", "-o", "spin.mp4"});
  EXPECT_EQ(result.exit_code, 4) << result.err;
  EXPECT_NE(result.err.find("/nowhere/ffmpeg: cannot be run"), std::string::npos) << result.err;
  EXPECT_EQ(read_file("spin.mp4"), "before");
  expect_refused({"-o", "one.mp4"}, "a video needs frames");
}

TEST_F(TurntableCommand, WithoutFfmpegTheCommandIsPrinted) {
  const ProgramResult result = render({"--turntable", "2", "-o", "spin.mp4"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(exists("spin-0000.png") && exists("spin-0001.png"));
  EXPECT_FALSE(exists("spin.mp4"));
  EXPECT_NE(result.out.find("ffmpeg -framerate 24 -start_number 0 -i "), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("spin-%04d.png"), std::string::npos) << result.out;
  EXPECT_NE(result.err.find("apt-get install ffmpeg"), std::string::npos) << result.err;
}

TEST_F(TurntableCommand, ASignalLeavesTheOldVideo) {
  write_file("spin.mp4", "before");
  write_ffmpeg("cat > \"$last\"\nkill -INT $PPID\n");
  // The stand-in interrupts at its end, when all frames are there: the video is complete.
  expect_done({"--turntable", "2", "-o", "spin.mp4"});
  EXPECT_EQ(read_file("spin.mp4").size(), 2U * 24 * 16 * 3);
  write_file("spin.mp4", "before");
  write_ffmpeg("head -c 1152 > \"$last\"\nkill -INT $PPID\ncat > /dev/null\n");
  const ProgramResult result = render({"--turntable", "400", "--spp", "16", "-o", "spin.mp4"});
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_NE(result.err.find("spin.mp4: was not written"), std::string::npos) << result.err;
  EXPECT_EQ(read_file("spin.mp4"), "before");
}

// The camera of a path looks as --orbit does at its keys.
TEST_F(TurntableCommand, CamerasFollowAPath) {
  write_file("path.json", R"({"interpolation": "linear", "keys": [
    {"time": 0, "position": [0, 0, 4], "target": [0, 0, 0]},
    {"time": 1, "position": [4, 0, 0], "target": [0, 0, 0], "fov": 30}]})");
  expect_done({"--camera-path", "path.json", "--frames", "0,2,8", "--fps", "8", "--integrator", "normal", "-o",
               "p_#.exr", "-o", "p_#.png"});
  expect_done({"--orbit", "0,90,4", "--integrator", "normal", "--time", "0", "-o", "first.png"});
  expect_done({"--orbit", "90,90,4", "--fov", "30", "--integrator", "normal", "--time", "1", "-o", "last.png"});
  expect_done({"--camera-path", "path.json", "--time", "0.25", "--integrator", "normal", "-o", "single.exr"});
  expect_similar("p_0.png", "first.png");
  expect_similar("p_8.png", "last.png");
  EXPECT_EQ(pixels("p_2.exr"), pixels("single.exr"));
  EXPECT_NE(pixels("p_0.exr"), pixels("p_2.exr"));
  const auto refused = [&](const std::string& json, int code, const std::string& why) {
    write_file("bad.json", json);
    const ProgramResult result = render({"--camera-path", "bad.json", "-o", "a.png"});
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_NE(result.err.find(why), std::string::npos) << result.err;
  };
  refused("[", 3, "is no camera path");
  refused(R"({"keys": []})", 3, "is no camera path");
  refused(R"({"keys": [{"time": 0, "position": [0, 0], "target": [0, 0, 0]}]})", 3, "keys[0].position");
  refused(
      R"({"keys": [{"time": 1, "position": [0,0,1], "target": [0,0,0]}, {"time": 1, "position": [0,0,1], "target": [0,0,0]}]})",
      3, "keys[1].time: is not after");
  expect_refused({"--camera-path", "path.json", "--orbit", "0,0,1"}, "--camera-path and --orbit");
  const ProgramResult missing = render({"--camera-path", "missing.json", "-o", "a.png"});
  EXPECT_EQ(missing.exit_code, 4) << missing.err;
}

TEST_F(TurntableCommand, CamerasFollowAnAnimationOfAnotherFile) {
  // A camera that moves from x = 0 to x = 2 in a second, at z = 4.
  write_file("flight.gltf", R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"name": "eye", "camera": 0, "translation": [9, 9, 9]}],
    "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7853981633974483, "znear": 0.1}}],
    "buffers": [{"byteLength": 32, "uri": "data:application/octet-stream;base64,AAAAAAAAgD8AAAAAAAAAAAAAgEAAAABAAAAAAAAAgEA="}],
    "bufferViews": [{"buffer": 0, "byteLength": 8}, {"buffer": 0, "byteOffset": 8, "byteLength": 24}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]},
                  {"bufferView": 1, "componentType": 5126, "count": 2, "type": "VEC3"}],
    "animations": [{"samplers": [{"input": 0, "output": 1}],
                    "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}]})");
  expect_done({"--camera-path", "flight.gltf", "--camera", "eye", "--frames", "0,6", "--fps", "8", "--integrator",
               "normal", "-o", "g_#.png"});
  expect_done({"--orbit", "0,90,4", "--time", "0", "--integrator", "normal", "-o", "first.png"});
  expect_similar("g_0.png", "first.png");
  expect_refused({"--camera-path", "flight.gltf", "--camera", "ear"}, "has no camera 'ear'");
  EXPECT_NE(pixels("g_0.png"), pixels("g_6.png"));
}

} // namespace
} // namespace kindling::test
