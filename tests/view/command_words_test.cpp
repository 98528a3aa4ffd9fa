// Command lines of frames are read as the settings that the frames were rendered with.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/parse_command_line.h"
#include "renderer/view/command_words.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace kindling {
namespace {

app::RenderOptions options_of(const std::vector<std::string>& words) {
  EXPECT_EQ(words.at(0), "kindling");
  std::vector<const char*> arguments;
  for (size_t i = 1; i < words.size(); ++i) arguments.push_back(words[i].c_str());
  const Result<app::CommandLine> line = app::parse_command_line(arguments);
  EXPECT_TRUE(line.ok()) << (line.ok() ? "" : line.error().message);
  return line.ok() ? std::get<app::RenderOptions>(line.value().command) : app::RenderOptions();
}

LinearFrame frame_of(const ImageSettings& image) {
  LinearFrame frame;
  frame.image = image;
  frame.size_px = *image.size_px;
  return frame;
}

ImageSettings some_image() {
  ImageSettings image;
  image.size_px = V2i(321, 123);
  image.spp = 37;
  image.planned_spp = 1024;
  return image;
}

TEST(CommandWords, NumbersKeepTheirBits) {
  ImageSettings image = some_image();
  image.orbit = V3f(-0.1f, std::nextafter(80.0f, 90.0f), 1.0f / 3.0f);
  image.target = V3f(-1e-20f, 1e7f / 3.0f, 0.1f);
  image.yfov_deg = 100.0 / 3.0;
  image.turn = CameraTurn{-100.0 / 7.0, V3f(0.1f, -1.0f / 3.0f, 1e-8f), image.target};
  image.time_s = -0.7;
  image.lens.f_stop = 1.1;
  image.lens.focus_distance_m = 2.0 / 3.0;
  image.lens.blades = 7;
  image.seed = 4711;
  image.guiding = Guiding::off;
  image.backfaces = Backfaces::cull;
  image.aovs.insert(Aov::depth);
  LinearFrame frame = frame_of(image);
  frame.world.studio = Studio::off;
  frame.world.variant_name = "a b's";
  const ViewState display{.display_view = "AgX", .exposure_stops = -1.3};
  const app::RenderOptions read = options_of(command_words(frame, display, "scenes/a b.glb", {"--max-bounces", "3"}));
  EXPECT_EQ(read.scene_file, "scenes/a b.glb");
  EXPECT_EQ(read.size_px, image.size_px);
  EXPECT_EQ(read.orbit, image.orbit);
  EXPECT_EQ(read.target, image.target);
  EXPECT_EQ(read.yfov_deg, image.yfov_deg);
  ASSERT_TRUE(read.turn.has_value());
  EXPECT_EQ(read.turn->angle_deg, image.turn->angle_deg);
  EXPECT_EQ(read.turn->axis, image.turn->axis);
  EXPECT_EQ(read.turn->around, image.turn->around);
  EXPECT_EQ(read.time_s, image.time_s);
  EXPECT_EQ(read.lens.f_stop, image.lens.f_stop);
  EXPECT_EQ(read.lens.focus_distance_m, image.lens.focus_distance_m);
  EXPECT_EQ(read.lens.blades, image.lens.blades);
  EXPECT_EQ(read.seed, image.seed);
  EXPECT_EQ(read.spp, 37U);
  EXPECT_EQ(read.planned_spp, 1024U);
  EXPECT_EQ(read.guiding, Guiding::off);
  EXPECT_EQ(read.backfaces, Backfaces::cull);
  EXPECT_EQ(read.studio, Studio::off);
  EXPECT_EQ(read.variant_name, "a b's");
  EXPECT_TRUE(read.aovs.contains(Aov::depth));
  EXPECT_EQ(read.view, "AgX");
  EXPECT_EQ(read.exposure_stops, -1.3);
  EXPECT_EQ(read.integrator.max_bounces, 3U);
  ASSERT_EQ(read.outputs.size(), 1U);
  EXPECT_EQ(read.outputs.front(), "a b-37spp.exr");
}

TEST(CommandWords, OrbitsWithoutPerspective) {
  ImageSettings image = some_image();
  image.orbit = V3f(0, 90, 2);
  image.orthographic_m = 10.0 / 3.0;
  const app::RenderOptions read = options_of(command_words(frame_of(image), {}, "a.glb", {}));
  EXPECT_EQ(read.orthographic_m, image.orthographic_m);
  EXPECT_FALSE(read.yfov_deg.has_value());
}

TEST(CommandWords, DefaultsAreLeftOut) {
  const std::vector<std::string> words = command_words(frame_of(some_image()), {}, "a.glb", {});
  for (const char* flag :
       {"--orbit", "--orthographic", "--turn", "--target", "--fov", "--time", "--camera", "--seed", "--guiding",
        "--studio", "--backfaces", "--aov", "--view", "--exposure", "--f-stop", "--denoise", "--path-reuse"})
    EXPECT_EQ(std::find(words.begin(), words.end(), flag), words.end()) << flag;
  EXPECT_EQ(words.back(), "a-37spp.png");
  (void)options_of(words);
}

TEST(CommandWords, PathReuseIsWrittenUnlessItIsChosen) {
  ImageSettings image = some_image();
  EXPECT_TRUE(options_of(command_words(frame_of(image), {}, "a.glb", {})).chooses_path_reuse);
  image.chooses_path_reuse = false;
  for (const int pixels : {1, 4}) {
    image.integrator.path_reuse = pixels;
    const app::RenderOptions read = options_of(command_words(frame_of(image), {}, "a.glb", {}));
    EXPECT_FALSE(read.chooses_path_reuse);
    EXPECT_EQ(read.integrator.path_reuse, pixels);
  }
}

TEST(CommandWords, APinholeIsWrittenOnce) {
  ImageSettings image = some_image();
  image.lens.pinhole = true;
  EXPECT_TRUE(options_of(command_words(frame_of(image), {}, "a.glb", {})).lens.pinhole);
}

// What `view` was given is passed on, unless the page writes it.
TEST(CommandWords, FlagsOfTheViewArePassedOn) {
  const char* const arguments[] = {
      "view",  "a.glb", "--env-color", "1,2,3", "--outlines", "--orbit", "1,2,3", "--port", "0", "--clamp-direct=5",
      "--spp", "9",     "--env-color", "3,2,1", "--threads",  "2"};
  const Result<app::CommandLine> view = app::parse_command_line(arguments);
  ASSERT_TRUE(view.ok()) << view.error().message;
  const auto& options = std::get<app::LiveOptions>(view.value().command);
  EXPECT_EQ(options.port, 0);
  EXPECT_EQ(options.image.spp, 9U);
  std::vector<std::string> passed_on = options.passed_on;
  ASSERT_EQ(passed_on.size(), 5U);
  const auto has = [&](const char* flag, const char* value) {
    const auto at = std::find(passed_on.begin(), passed_on.end(), flag);
    return at != passed_on.end() && (value == nullptr || *std::next(at) == value);
  };
  EXPECT_TRUE(has("--env-color", "3,2,1")) << "the last use counts";
  EXPECT_TRUE(has("--outlines", nullptr));
  EXPECT_TRUE(has("--clamp-direct", "5"));
}

} // namespace
} // namespace kindling
