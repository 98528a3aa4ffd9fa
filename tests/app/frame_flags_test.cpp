// Frames from flags, their file names, and their progress and reports.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/frame_flags.h"
#include "renderer/app/output/frame_names.h"
#include "renderer/facade/shutter.h"

#include "renderer/app/options/options.h"
#include "renderer/app/render/frame_report.h"
#include "renderer/app/terminal/progress_format.h"
#include "tests/app/render_line.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace kindling::app {
namespace {

using Numbers = std::vector<int>;

Numbers frames(const std::string& text) {
  const Result<Numbers> parsed = parse_frames(text);
  EXPECT_TRUE(parsed.ok()) << text << ": " << parsed.error().message;
  return parsed.ok() ? parsed.value() : Numbers();
}

std::string refusal_of(const std::string& text) {
  const Result<Numbers> parsed = parse_frames(text);
  EXPECT_FALSE(parsed.ok()) << text;
  return parsed.ok() ? "" : parsed.error().message;
}

TEST(FrameFlags, ParsesRanges) {
  EXPECT_EQ(frames("7"), Numbers{7});
  EXPECT_EQ(frames("-7"), Numbers{-7});
  EXPECT_EQ(frames("1-4"), (Numbers{1, 2, 3, 4}));
  EXPECT_EQ(frames("4-4"), Numbers{4});
  EXPECT_EQ(frames("1-10x3"), (Numbers{1, 4, 7, 10}));
  EXPECT_EQ(frames("1-9x3"), (Numbers{1, 4, 7}));
  EXPECT_EQ(frames("-2-1"), (Numbers{-2, -1, 0, 1}));
  EXPECT_EQ(frames("-5--3"), (Numbers{-5, -4, -3}));
  EXPECT_EQ(frames("1-3,20"), (Numbers{1, 2, 3, 20}));
  EXPECT_EQ(frames("20,1-3,2-4"), (Numbers{20, 1, 2, 3, 4})); // in that order, each once
  EXPECT_EQ(frames("0001-0002"), (Numbers{1, 2}));
}

TEST(FrameFlags, RefusesWrongRanges) {
  EXPECT_EQ(refusal_of("5-1"), "'5-1' ends before it begins; use 1-5");
  EXPECT_NE(refusal_of("1-5x0").find("the step is not a whole number above 0"), std::string::npos);
  EXPECT_NE(refusal_of("1-5x-1").find("the step"), std::string::npos);
  for (const char* text : {"", "a", "1-", "-", "--1", "1-2-3", "1..5", "1-5x", "1-5x2y", "1,,2", "1.5", "1-99999999",
                           "3000000000", "-0-99999999999999999999"})
    (void)refusal_of(text);
  EXPECT_NE(refusal_of("1-2000000").find("more than 1000000 frames"), std::string::npos);
  EXPECT_EQ(frames("0-9999999x10").size(), 1000000U);
}

TEST(FrameFlags, PutsTheNumberIntoNames) {
  EXPECT_EQ(name_of_frame("a_####.png", 7), "a_0007.png");
  EXPECT_EQ(name_of_frame("a_####.png", -7), "a_-0007.png");
  EXPECT_EQ(name_of_frame("a_####.png", 123456), "a_123456.png");
  EXPECT_EQ(name_of_frame("a_#.png", 0), "a_0.png");
  EXPECT_EQ(name_of_frame("####/a.png", 12), "0012/a.png");
  EXPECT_EQ(name_of_frame("##", 1), "01");
  EXPECT_EQ(name_of_frame("a.png", 1), "a.png");
  EXPECT_EQ(count_frame_groups("a.png"), 0);
  EXPECT_EQ(count_frame_groups("a_##.png"), 1);
  EXPECT_EQ(count_frame_groups("#/a_##.png"), 2);
}

TEST(FrameFlags, FrameHasOptionsOfASingleRender) {
  const RenderOptions options = options_of(
      {"--frames", "1-3", "--fps", "25", "--time", "2", "-o", "x/b_###.exr", "-o", "#.png", "--stats", "s##.json"});
  const RenderOptions third = options_of_frame(options, 3);
  EXPECT_TRUE(third.frames.numbers.empty());
  EXPECT_EQ(*third.time_s, 2.0 + 3.0 / 25.0);
  EXPECT_EQ(third.outputs, (std::vector<std::filesystem::path>{"x/b_003.exr", "3.png"}));
  EXPECT_EQ(third.stats_file, "s03.json");
  const RenderOptions plain = options_of_frame(options_of({"--frames=-12"}), -12);
  EXPECT_EQ(*plain.time_s, -0.5);
  EXPECT_EQ(plain.outputs, (std::vector<std::filesystem::path>{"a--0012.png"}));
  EXPECT_TRUE(plain.stats_file.empty());
  // An image of a part of the samples would be taken for the frame.
  const RenderOptions part = options_of_frame(options_of({"--frames=12", "--part", "2/3", "--tile-part", "1/4"}), 12);
  EXPECT_EQ(part.outputs, (std::vector<std::filesystem::path>{"a-0012-part-2-of-3-tiles-1-of-4.kacc"}));
}

TEST(FrameFlags, ShutterAngleUsesTheFrameRate) {
  const RenderOptions options = options_of_frame(options_of({"--frames", "24", "--shutter-angle", "180"}), 24);
  const std::optional<Shutter> shutter = choose_shutter({}, kNone, options).value();
  ASSERT_TRUE(shutter);
  EXPECT_EQ(shutter->open_s, 1.0);
  EXPECT_DOUBLE_EQ(shutter->close_s, 1.0 + 1.0 / 48.0);
}

TEST(FrameFlags, NamesAreLiteralWithoutFrames) {
  EXPECT_EQ(options_of({"-o", "a_##_#.png"}).outputs, (std::vector<std::filesystem::path>{"a_##_#.png"}));
}

TEST(FrameFlags, RefusesWrongCombinations) {
  EXPECT_EQ(refusal({"--force"}), "--force: has no meaning without --frames, --turntable or --checkpoint");
  EXPECT_TRUE(refusal({"--frames", "1-x"}).starts_with("--frames: '1-x' is not a list of frames; use"));
  EXPECT_EQ(refusal({"--frames", "1-3", "-o", "a.png"}), "--output: a.png: all frames would have this name; put #### "
                                                         "where the frame number belongs, such as frame_####.png");
  EXPECT_EQ(refusal({"--frames", "3", "-o", "#/a_##.png"}),
            "--output: #/a_##.png: more than one group of #; use one for the frame number, such as frame_####.png");
  EXPECT_TRUE(refusal({"--frames", "3", "--stats", "#_#.json"}).starts_with("--stats: #_#.json: more than one group"));
  EXPECT_TRUE(refusal({"--frames", "1-3", "--pixel", "1,1"}).starts_with("--pixel: replays a sample of one frame"));
  EXPECT_EQ(options_of({"--frames", "1-3", "--frames", "2", "--pixel", "1,1"}).frames.numbers, Numbers{2});
}

TEST(FrameProgress, PredictsRemainingTime) {
  EXPECT_FALSE(remaining_seconds_of_frames(0, 0.0, 9, 5.0, std::nullopt));
  // The first frame: 4 s are done, 6 s remain, then nine frames like it.
  EXPECT_DOUBLE_EQ(*remaining_seconds_of_frames(0, 0.0, 9, 4.0, 6.0), 6.0 + 9.0 * 10.0);
  // Two frames took 20 s; this one has had 3.
  EXPECT_DOUBLE_EQ(*remaining_seconds_of_frames(2, 20.0, 3, 3.0, std::nullopt), 7.0 + 30.0);
  EXPECT_DOUBLE_EQ(*remaining_seconds_of_frames(2, 20.0, 3, 30.0, std::nullopt), 30.0);
  EXPECT_DOUBLE_EQ(*remaining_seconds_of_frames(2, 20.0, 0, 3.0, 1.5), 1.5);
}

TEST(FrameProgress, LinesNameTheFrame) {
  ProgressState state;
  state.phase = Phase::render;
  state.fraction = 0.5;
  state.remaining_s = 80.0;
  state.frame = FrameState{12, 3, 10, 750.0};
  EXPECT_TRUE(format_plain_line(state).starts_with("frame 12 (3 of 10): render 50% ")) << format_plain_line(state);
  EXPECT_NE(format_plain_line(state).find("1:20 left, 12:30 for all"), std::string::npos) << format_plain_line(state);
  const std::string status = format_status_line(state, 100);
  EXPECT_TRUE(status.starts_with("3/10 render   [")) << status;
  EXPECT_NE(status.find("12:30 for all"), std::string::npos) << status;
  EXPECT_LE(format_status_line(state, 40).size(), 40U);
  const nlohmann::json json = nlohmann::json::parse(format_json_line(state));
  EXPECT_EQ(json["frame"], 12);
  EXPECT_EQ(json["frame_index"], 3);
  EXPECT_EQ(json["frame_count"], 10);
  EXPECT_EQ(json["frames_remaining_s"], 750.0);
  state.frame.reset();
  EXPECT_FALSE(nlohmann::json::parse(format_json_line(state)).contains("frame"));
}

TEST(FrameReport, Numbers) {
  EXPECT_EQ(format_frame_numbers({}), "");
  EXPECT_EQ(format_frame_numbers({7}), "7");
  EXPECT_EQ(format_frame_numbers({1, 2}), "1, 2");
  EXPECT_EQ(format_frame_numbers({1, 2, 3, 7, 9, 10, 11}), "1-3, 7, 9-11");
  EXPECT_EQ(format_frame_numbers({3, 2, 1}), "3, 2, 1");
}

TEST(FrameReport, Summary) {
  FramesReport report;
  report.wanted = 4;
  report.rendered = {1, 2};
  report.skipped = {3};
  report.load_s = 1.5;
  report.phases.render_s = 8.0;
  report.total_s = 12.0;
  const std::string text = format_frames_summary(report);
  EXPECT_TRUE(text.starts_with("rendered 2 of 4 frames in 12.0 s: 1, 2\n  skipped 1 frame that was there: 3\n"))
      << text;
  EXPECT_NE(text.find("render 4.00 s"), std::string::npos) << text;
  report.statistics = {R"({"frame": 1})"};
  const nlohmann::json json = nlohmann::json::parse(format_frames_json(report, false));
  EXPECT_EQ(json["frames"][0]["frame"], 1);
  EXPECT_EQ(json["skipped"], nlohmann::json({3}));
  EXPECT_FALSE(nlohmann::json::parse(format_frames_json(report, true)).contains("frames"));
}

} // namespace
} // namespace kindling::app
