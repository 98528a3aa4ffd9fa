// Text of numbers, tables and progress; choices of cameras and image sizes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/output/report.h"
#include "renderer/app/terminal/exit_code.h"
#include "renderer/app/terminal/progress_format.h"
#include "renderer/app/text/text_format.h"
#include "renderer/facade/choose.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace kindling::app {
namespace {

TEST(TextFormat, Seconds) {
  EXPECT_EQ(format_seconds(0.0123), "0.012 s");
  EXPECT_EQ(format_seconds(4.5678), "4.57 s");
  EXPECT_EQ(format_seconds(12.34), "12.3 s");
  EXPECT_EQ(format_seconds(59.96), "1:00");
  EXPECT_EQ(format_seconds(83.4), "1:23");
  EXPECT_EQ(format_seconds(3723.0), "1:02:03");
  EXPECT_EQ(format_seconds(-1.0), "0.000 s");
  EXPECT_EQ(format_seconds(kInfinity), "-");
}

TEST(TextFormat, BytesAndCounts) {
  EXPECT_EQ(format_bytes(812), "812 B");
  EXPECT_EQ(format_bytes(1536), "1.50 KiB");
  EXPECT_EQ(format_bytes(512ULL << 20), "512 MiB");
  EXPECT_EQ(format_bytes((1ULL << 30) - 1), "1.00 GiB");
  EXPECT_EQ(format_count(812.0), "812");
  EXPECT_EQ(format_count(12345.0), "12.3 k");
  EXPECT_EQ(format_count(999999.0), "1.00 M");
  EXPECT_EQ(format_count(4.567e6), "4.57 M");
}

TEST(TextFormat, Printable) {
  EXPECT_EQ(printable("a\x1b[31mb"), "a?[31mb");
  EXPECT_EQ(printable("two\nlines"), "two lines");
  EXPECT_EQ(printable("\x9b"
                      "31m, \xff\xe9"),
            "?31m, \xff\xe9"); // C1 of 8-bit terminals; other bytes are kept
  EXPECT_EQ(printable("\xe2\x80\xae"
                      "gpj.exe"),
            "?gpj.exe"); // U+202E, right-to-left override
  EXPECT_EQ(printable("\xe6\x97\xa5\xf0\x9f\x8e\xa8"), "\xe6\x97\xa5\xf0\x9f\x8e\xa8");
  EXPECT_EQ(printable("cut \xe6\x97"), "cut \xe6?"); // 0x97 alone is a C1 byte
  EXPECT_EQ(printable_lines("a\tb\x1b\nc\r\n"), "a\tb?\nc \n");
  EXPECT_EQ(printable("\xc2\x9b"
                      "31m"),
            "?31m"); // the 8-bit form of ESC [
  EXPECT_EQ(printable("Z\xc3\xbcrich"), "Z\xc3\xbcrich");
}

TEST(TextFormat, ShellQuote) {
  EXPECT_EQ(shell_quote("a/b-c_1.glb"), "a/b-c_1.glb");
  EXPECT_EQ(shell_quote("my scene.glb"), "'my scene.glb'");
  EXPECT_EQ(shell_quote("it's"), "'it'\\''s'");
  EXPECT_EQ(shell_quote(""), "''");
  EXPECT_EQ(shell_quote("$HOME"), "'$HOME'");
}

TEST(TextFormat, Table) {
  TextTable table({{"#", true}, {"name"}, {"n", true}});
  table.add({"0", "Z\xc3\xbcrich", "7"});
  table.add({"10", "b", "1234"});
  EXPECT_EQ(table.str(), "   #  name       n\n   0  Z\xc3\xbcrich     7\n  10  b       1234\n");
  TextTable wide({{"name"}});
  wide.add({std::string(200, 'x')});
  EXPECT_EQ(wide.str(), "  name\n  " + std::string(TextTable::kMaxCell - 3, 'x') + "...\n");
}

ProgressState render_state() {
  ProgressState state;
  state.phase = Phase::render;
  state.fraction = 0.5;
  state.samples_per_pixel = 32.0;
  state.spp_wanted = 64;
  state.rays = 1000000;
  state.rays_per_s = 12.34e6;
  state.elapsed_s = 83.0;
  state.remaining_s = 80.0;
  state.resident_bytes = 512ULL << 20;
  return state;
}

TEST(ProgressFormat, StatusLine) {
  EXPECT_EQ(format_status_line(render_state(), 120),
            "render   [############------------]  50.0%  32/64 spp  1:20 left  12.3 Mrays/s  1:23 elapsed  512 MiB");
}

TEST(ProgressFormat, StatusLineNeverWraps) {
  for (int columns = 0; columns <= 200; ++columns)
    EXPECT_LT(static_cast<int>(format_status_line(render_state(), columns).size()), std::max(columns, 1)) << columns;
}

TEST(ProgressFormat, NarrowTerminalsKeepTheImportantParts) {
  const std::string line = format_status_line(render_state(), 40);
  EXPECT_NE(line.find("50.0%"), std::string::npos) << line;
  EXPECT_NE(line.find('['), std::string::npos) << line;
}

TEST(ProgressFormat, PlainLine) {
  EXPECT_EQ(format_plain_line(render_state()), "render 50% 32/64 spp, 1:20 left, 12.3 Mrays/s, 1:23 elapsed, 512 MiB");
  ProgressState load;
  load.fraction = 0.25;
  load.elapsed_s = 0.5;
  EXPECT_EQ(format_plain_line(load), "load 25% 0.500 s elapsed");
}

TEST(ProgressFormat, ConvergedPixels) {
  ProgressState state = render_state();
  state.converged = 0.999;
  EXPECT_EQ(format_plain_line(state),
            "render 50% 32/64 spp, 99% converged, 1:20 left, 12.3 Mrays/s, 1:23 elapsed, 512 MiB");
  EXPECT_EQ(nlohmann::json::parse(format_json_line(state))["converged"], 0.999);
  EXPECT_TRUE(nlohmann::json::parse(format_json_line(render_state()))["converged"].is_null());
}

TEST(ProgressFormat, JsonLine) {
  const nlohmann::json json = nlohmann::json::parse(format_json_line(render_state()));
  EXPECT_EQ(json["event"], "progress");
  EXPECT_EQ(json["phase"], "render");
  EXPECT_EQ(json["fraction"], 0.5);
  EXPECT_EQ(json["spp_wanted"], 64);
  EXPECT_EQ(json["remaining_s"], 80.0);
  EXPECT_TRUE(nlohmann::json::parse(format_json_line(ProgressState{}))["remaining_s"].is_null());
}

TEST(ProgressFormat, FractionsAreClamped) {
  ProgressState state;
  state.fraction = 7.0;
  EXPECT_NE(format_plain_line(state).find("100%"), std::string::npos);
  state.fraction = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(format_plain_line(state).find(" 0%"), std::string::npos);
}

TEST(ProgressFormat, ShowsSamplesOfAnUnfinishedPass) {
  ProgressState state;
  state.phase = Phase::render;
  state.spp_wanted = 64;
  for (const auto& [spp, text] :
       {std::pair(0.0, " 0/64 spp"), {3.86, " 3.8/64 spp"}, {4.0, " 4/64 spp"}, {63.97, " 63/64 spp"}}) {
    state.samples_per_pixel = spp;
    EXPECT_NE(format_plain_line(state).find(text), std::string::npos) << format_plain_line(state);
  }
}

TEST(ProgressFormat, RemainingTime) {
  EXPECT_DOUBLE_EQ(remaining_seconds(0.25, 10.0).value(), 30.0);
  EXPECT_DOUBLE_EQ(remaining_seconds(1.0, 10.0).value(), 0.0);
  EXPECT_FALSE(remaining_seconds(0.001, 10.0).has_value());
  EXPECT_FALSE(remaining_seconds(0.5, 0.1).has_value());
  EXPECT_FALSE(remaining_seconds(std::numeric_limits<double>::quiet_NaN(), 10.0).has_value());
}

TEST(Report, RatesAndFirstPixel) {
  RenderReport report;
  EXPECT_EQ(report.rays_per_s(), 0.0); // not infinite
  report.statistics.render_s = 2.0;
  report.statistics.first_pass_s = 0.25;
  report.statistics.rays.camera = 10;
  report.statistics.rays.shadow = 30;
  report.statistics.rays.paths = 10;
  report.times.before_render_s = 1.0;
  EXPECT_DOUBLE_EQ(report.rays_per_s(), 20.0);
  EXPECT_DOUBLE_EQ(report.paths_per_s(), 5.0);
  EXPECT_DOUBLE_EQ(report.time_to_first_pixel_s(), 1.25);
  const nlohmann::json json = nlohmann::json::parse(format_stats_json(report, false));
  EXPECT_EQ(json["rays"]["total"], 40);
  EXPECT_FALSE(json.contains("event"));
  EXPECT_TRUE(json["shutter"].is_null());
  EXPECT_EQ(format_stats_json(report, true).find('\n'), std::string::npos);
}

TEST(Report, DescribesMotion) {
  RenderReport report;
  report.shutter = Shutter{1.5, 2.0};
  EXPECT_EQ(describe_motion(report.world.motion), "motion: nothing moves while the shutter is open");
  report.world.motion = {3, 1, 9, 2 << 20};
  EXPECT_EQ(describe_motion(report.world.motion),
            "motion: 3 instances that move, 1 mesh that deforms, 9 keys at most, 2.00 MiB");
  const nlohmann::json shutter = nlohmann::json::parse(format_stats_json(report, false))["shutter"];
  EXPECT_EQ(shutter["open_s"], 1.5);
  EXPECT_EQ(shutter["close_s"], 2.0);
  EXPECT_EQ(shutter["moving_instances"], 3);
  EXPECT_EQ(shutter["deforming_meshes"], 1);
  EXPECT_EQ(shutter["max_keys"], 9);
  EXPECT_EQ(shutter["key_bytes"], 2 << 20);
}

TEST(Choose, NamesBeforeNumbers) {
  const std::vector<std::string> names{"Front", "2", "", "Side"};
  EXPECT_EQ(find_by_name_or_index("Side", names), 3);
  EXPECT_EQ(find_by_name_or_index("2", names), 1);
  EXPECT_EQ(find_by_name_or_index("3", names), 3);
  EXPECT_FALSE(find_by_name_or_index("4", names).has_value());
  EXPECT_FALSE(find_by_name_or_index("", names).has_value());
  EXPECT_FALSE(find_by_name_or_index("-1", names).has_value());
  EXPECT_FALSE(find_by_name_or_index("0", {}).has_value());
}

TEST(Choose, CamerasByNodeCameraAndNumber) {
  Scene scene;
  scene.cameras.resize(2);
  scene.cameras[0].name = "wide";
  scene.cameras[1].kind = SceneCamera::Kind::orthographic;
  scene.nodes.resize(2);
  scene.nodes[0].name = "Front";
  PosedScene posed;
  posed.cameras = {{0, 0, M44f()}, {1, 1, M44f()}};
  ImageSettings options;
  EXPECT_EQ(choose_camera(scene, posed, options).value()->camera.name, "wide");
  options.camera = "Front";
  EXPECT_EQ(choose_camera(scene, posed, options).value()->camera.name, "wide");
  options.camera = "wide";
  EXPECT_EQ(choose_camera(scene, posed, options).value()->camera.name, "wide");
  options.yfov_deg = 90.0;
  EXPECT_FLOAT_EQ(choose_camera(scene, posed, options).value()->camera.yfov_rad, kPi / 2.0f);
  options.camera = "1";
  EXPECT_FALSE(choose_camera(scene, posed, options).ok()); // orthographic: no field of view
  options.yfov_deg.reset();
  EXPECT_EQ(choose_camera(scene, posed, options).value()->camera.kind, SceneCamera::Kind::orthographic);
  options.camera = "2";
  EXPECT_EQ(choose_camera(scene, posed, options).error().message, "--camera:  has no camera '2'; use 0 (Front) or 1");
  options.camera.clear();
  EXPECT_FALSE(choose_camera(scene, PosedScene{}, options).value().has_value());
}

TEST(Choose, Sizes) {
  ImageSettings options;
  SceneCamera camera;
  camera.aspect_ratio = 2.0f;
  EXPECT_EQ(choose_size(&camera, options).value(), V2i(1280, 640));
  EXPECT_EQ(choose_size(nullptr, options).value(), V2i(1280, 720));
  options.scale = 0.5;
  EXPECT_EQ(choose_size(&camera, options).value(), V2i(640, 320));
  options.size_px = V2i(99, 3);
  EXPECT_EQ(choose_size(&camera, options).value(), V2i(50, 2));
  options.scale = 1e-6;
  EXPECT_EQ(choose_size(&camera, options).value(), V2i(1, 1));
  options.scale = 64.0;
  options.size_px = V2i(2000, 1);
  EXPECT_FALSE(choose_size(&camera, options).ok());
}

TEST(ExitCode, FollowsErrorsAndSignals) {
  EXPECT_EQ(exit_code_of(ErrorKind::render_failed), 1);
  EXPECT_EQ(exit_code_of(ErrorKind::usage), 2);
  EXPECT_EQ(exit_code_of(ErrorKind::scene_invalid), 3);
  EXPECT_EQ(exit_code_of(ErrorKind::input_output), 4);
  EXPECT_EQ(exit_code_of_signal(2), 130);
  EXPECT_EQ(exit_code_of_signal(15), 143);
}

} // namespace
} // namespace kindling::app
