// The defaults that the help of each command prints are those of the options.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/camera/camera.h"
#include "renderer/camera/place_camera.h"
#include "renderer/facade/light_sizes.h"
#include "renderer/session/pixel_settings.h"
#include "tests/app/render_line.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <regex>
#include <set>
#include <sstream>

namespace kindling::app {
namespace {

struct FlagHelp {
  std::string description; // on one line
  std::string fallback;    // the default, in brackets at its end; empty without one
};

// The flags of a command, by their long names.
std::map<std::string, FlagHelp> help_of(std::vector<const char*> command) {
  command.push_back("--help");
  std::map<std::string, FlagHelp> flags;
  const Result<CommandLine> line = parse_command_line(command);
  EXPECT_TRUE(line.ok());
  if (!line.ok()) return flags;
  std::istringstream text(std::get<PrintText>(line.value().command).text);
  const std::regex start(R"(^  (?:-\w,)?(--[a-z][a-z0-9-]*)(?: \S+)? *(.*))");
  std::smatch match;
  std::string* last = nullptr;
  for (std::string row; std::getline(text, row);) {
    if (std::regex_match(row, match, start)) {
      last = &flags[match[1]].description;
      *last = match[2];
    } else if (last != nullptr && row.starts_with("      ")) {
      *last += (last->empty() ? "" : " ") + row.substr(row.find_first_not_of(' '));
    } else {
      last = nullptr;
    }
  }
  const std::regex brackets(R"(.*\[(.*)\]$)");
  for (auto& [flag, help] : flags)
    if (std::regex_match(help.description, match, brackets)) help.fallback = match[1];
  return flags;
}

// All settings of a render as text.
std::string everything(const RenderOptions& o) {
  return pixel_settings(o, o, {}) +
         fmt::format("; {} {} {} {} {} {} {} {} {} {} {} {}", o.exr_half, o.png_bits, *o.exposure_stops, o.threads,
                     o.tile_size_px, schedule_name(o.schedule), o.integrator.batch_size, o.checkpoint.every_s,
                     progress_mode_name(o.progress), o.replay_sample, whitted_form_name(o.integrator.whitted.form),
                     o.integrator.whitted.cache);
}

// Other flags that a flag requires.
std::vector<const char*> companions(const std::string& flag) {
  static const std::map<std::string, std::vector<const char*>> kCompanions{
      {"--min-spp", {"--noise-threshold", "0.1"}},
      {"--env-rotation", {"--env", "a.hdr"}},
      {"--env-intensity", {"--env", "a.hdr"}},
      {"--target", {"--orbit", "0,90,1"}},
      {"--orbit-axis", {"--turn", "30"}},
      {"--sample", {"--pixel", "1,1"}},
      {"--checkpoint-every", {"--checkpoint", "a.kacc"}},
      {"--trace-depth", {"--tracer", "optimized"}},
      {"--ambient", {"--tracer", "optimized"}},
      {"--light-samples", {"--tracer", "optimized"}},
      {"--glossy-samples", {"--tracer", "optimized"}},
      {"--whitted-cache", {"--tracer", "optimized"}},
      {"--whitted-form", {"--tracer", "optimized"}}};
  const auto found = kCompanions.find(flag);
  return found == kCompanions.end() ? std::vector<const char*>() : found->second;
}

TEST(Help, DefaultsOfRenderChangeNothing) {
  size_t values = 0;
  for (const auto& [flag, help] : help_of({"render"})) {
    if (help.fallback.find_first_of(" ;$'") != std::string::npos || help.fallback.empty()) continue; // words
    if (help.fallback == "none" || help.fallback == "all" || help.fallback.starts_with("--")) continue;
    if (flag == "--light-radius" || flag == "--sun-angle")
      continue; // unset, which DefaultsInWordsMatchTheOptions checks
    SCOPED_TRACE(flag + " " + help.fallback);
    std::vector<const char*> with = companions(flag), without = with;
    with.push_back(flag.c_str());
    with.push_back(help.fallback.c_str());
    EXPECT_EQ(everything(options_of(with)), everything(options_of(without)));
    ++values;
  }
  EXPECT_GE(values, 30U);
}

TEST(Help, EveryValueHasADefault) {
  const std::set<std::string> kWithout{"--compare",
                                       "--force",
                                       "--follow-links",
                                       "--outlines",
                                       "--quiet",
                                       "--verbose",
                                       "--help",
                                       "--pixel",
                                       "--list-cameras",
                                       "--list-scenes",
                                       "--list-variants",
                                       "--list-extensions",
                                       "--extension-table",
                                       "--json",
                                       "--no-embree-calls",
                                       "--quick",
                                       "--strict",
                                       "--tev"};
  for (const char* command : {"render", "info", "shootout", "scaling", "resume", "view"}) {
    for (const auto& [flag, help] : help_of({command})) {
      EXPECT_NE(help.description, "") << command << " " << flag;
      if (kWithout.contains(flag)) continue;
      EXPECT_NE(help.fallback, "") << command << " " << flag << ": " << help.description;
    }
  }
}

TEST(Help, DefaultsInWordsMatchTheOptions) {
  const std::map<std::string, FlagHelp> render = help_of({"render"});
  const auto fallback = [&](const char* flag) { return render.at(flag).fallback; };
  const V2i size = default_image_size(std::nullopt);
  EXPECT_NE(fallback("--size").find(fmt::format("{}x{} without", size.x, size.y)), std::string::npos);
  EXPECT_EQ(fallback("--spp"), fmt::format("{}; {} with --noise-threshold; unlimited with --time-limit",
                                           options_of({}).samples_per_pixel(),
                                           options_of({"--noise-threshold", "0.1"}).samples_per_pixel()));
  EXPECT_EQ(fallback("--filter-width"), "1.5; box 1; mitchell 4");
  for (const FilterKind kind : {FilterKind::blackman_harris, FilterKind::gaussian})
    EXPECT_EQ(default_filter_width(kind), 1.5f);
  const IntegratorSettings settings = options_of({}).integrator;
  EXPECT_EQ(settings.max_diffuse_bounces, settings.max_bounces);
  EXPECT_EQ(settings.max_glossy_bounces, settings.max_bounces);
  EXPECT_EQ(fallback("--max-transmission-bounces"),
            fmt::format("--max-bounces + {}", settings.max_transmission_bounces - settings.max_bounces));
  EXPECT_EQ(fallback("--max-diffuse-bounces"), "--max-bounces");
  EXPECT_EQ(options_of({"--frames", "1-2"}).shutter.frames_per_s, 24.0);
  EXPECT_EQ(fallback("--fps"), "24 with --frames");
  // A 24 mm high sensor: 12 mm over the tangent of half of the field of view.
  EXPECT_NE(fallback("--focal-length").find("24 mm"), std::string::npos);
  EXPECT_NEAR(focal_length_of(2.0f * std::atan(0.5f)), 0.024f, 1e-7f);
  const WhittedSettings optimized = options_of({"--tracer", "optimized"}).integrator.whitted;
  EXPECT_NE(render.at("--tracer")
                .description.find(fmt::format("--max-reflections {} (optimized)", optimized.max_reflections)),
            std::string::npos);
  Scene scene;
  scene.lights.resize(1);
  apply_light_options({}, scene);
  EXPECT_EQ(scene.lights[0].radius_m.value_or(0.0f), 0.0f);
  EXPECT_EQ(scene.lights[0].angular_diameter_rad.value_or(0.0f), 0.0f);
  EXPECT_EQ(fallback("--light-radius"), "0");
  EXPECT_EQ(fallback("--sun-angle"), "0");
}

TEST(Help, DefaultsOfShootoutAndScaling) {
  const auto parsed = [](std::vector<const char*> words) { return parse_command_line(words).value().command; };
  const auto shootout = std::get<ShootoutOptions>(parsed({"shootout", "a.glb"}));
  const std::map<std::string, FlagHelp> race = help_of({"shootout"});
  EXPECT_EQ(race.at("--accel").fallback, "embree,embree:non-robust,embree:best:non-robust,kdtree");
  EXPECT_EQ(parse_accelerator_variants(race.at("--accel").fallback).value(), shootout.accelerators);
  EXPECT_EQ(race.at("--rays-per-kind").fallback, fmt::format("{}", shootout.rays_per_kind));
  EXPECT_EQ(race.at("--batch-size").fallback,
            fmt::format("{}", IntegratorSettings().batch_size)); // the batch size of rendering
  EXPECT_EQ(race.at("--repeat").fallback, fmt::format("{}", shootout.repeat));
  EXPECT_EQ(race.at("--clock").fallback, "wall");
  const std::map<std::string, FlagHelp> scaling = help_of({"scaling"});
  const auto plain = std::get<ScalingOptions>(parsed({"scaling", "a.glb"}));
  const auto quick = std::get<ScalingOptions>(parsed({"scaling", "a.glb", "--quick"}));
  EXPECT_EQ(scaling.at("--accel").fallback, "kdtree,embree");
  EXPECT_EQ(scaling.at("--schedule").fallback, "tiles,regions");
  EXPECT_EQ(scaling.at("--repeat").fallback, fmt::format("{}; {} with --quick", plain.repeat, quick.repeat));
  EXPECT_EQ(scaling.at("--seconds").fallback, fmt::format("{:g}; {:g} with --quick", *plain.seconds, *quick.seconds));
}

} // namespace
} // namespace kindling::app
