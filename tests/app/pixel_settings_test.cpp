// The settings of an image contain exactly the flags that its pixels depend on.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/parse_command_line.h"
#include "renderer/facade/shutter.h"
#include "renderer/session/pixel_settings.h"

#include "renderer/app/terminal/version.h"
#include "renderer/facade/choose.h"
#include "renderer/session/render_identity.h"

#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>

namespace kindling::app {
namespace {

using Words = std::vector<std::string>;

RenderOptions parsed_options(const Words& flags) {
  std::vector<const char*> arguments{"render", "a.glb"};
  for (const std::string& flag : flags) arguments.push_back(flag.c_str());
  const Result<CommandLine> line = parse_command_line(arguments);
  EXPECT_TRUE(line.ok()) << testing::PrintToString(flags) << (line.ok() ? "" : line.error().message);
  return line.ok() ? std::get<RenderOptions>(line.value().command) : RenderOptions{};
}

// The settings for a scene without cameras, shutters and a second scene.
std::string settings(const Words& flags, uint64_t environment_hash = 7) {
  const RenderOptions options = parsed_options(flags);
  ResolvedImage resolved;
  const Result<V2i> size = choose_size(nullptr, options);
  EXPECT_TRUE(size.ok()) << size.error().message;
  resolved.size_px = size.value();
  Scene scene;
  scene.scenes.resize(1);
  const Result<std::optional<Shutter>> shutter = choose_shutter(scene, 0, options);
  EXPECT_TRUE(shutter.ok());
  resolved.shutter = shutter.value();
  resolved.time_s = time_of_image(shutter.value(), options);
  const auto index = [](const std::string& text) { return text.empty() ? 0 : std::stoi(text); };
  resolved.scene = index(options.scene_name);
  resolved.variant = index(options.variant_name);
  if (!options.orbit) resolved.camera = index(options.camera);
  resolved.environment_hash = environment_hash;
  return pixel_settings(options, options, resolved);
}

struct FlagCase {
  bool of_image = true;
  Words with;    // other flags that this one requires
  Words changed; // the flag with another value
};

// Every flag of `kindling render` has a line here, which states whether pixels depend on it.
const std::map<std::string, FlagCase>& flag_cases() {
  static const Words kNone, kWhitted{"--integrator", "whitted"}, kLens{"--f-stop", "2"}, kEnv{"--env", "a.hdr"};
  static const std::map<std::string, FlagCase> kCases{
      {"--output", {false, kNone, {"--output", "b.png"}}},
      {"--size", {true, kNone, {"--size", "640x360"}}},
      {"--scale", {true, kNone, {"--scale", "0.5"}}},
      {"--crop", {true, kNone, {"--crop", "0,0,8,8"}}},
      {"--aov", {true, {"-o", "a.exr"}, {"--aov", "depth"}}},
      {"--light-groups", {true, {"-o", "a.exr"}, {"--light-groups", "kind"}}},
      {"--cryptomatte", {true, {"-o", "a.exr"}, {"--cryptomatte", "object"}}},
      {"--shadow-catcher", {true, kNone, {"--shadow-catcher", "floor"}}},
      {"--shadow-catchers", {true, kNone, {"--shadow-catchers", "extras"}}},
      {"--cryptomatte-levels", {false, kNone, {"--cryptomatte-levels", "4"}}},
      {"--exr-float", {false, kNone, {"--exr-float"}}},
      {"--png-bits", {false, kNone, {"--png-bits", "16"}}},
      {"--jpeg-quality", {false, kNone, {"--jpeg-quality", "50"}}},
      {"--denoise", {true, kNone, {"--denoise", "best"}}}, // by the AOVs that it records
      {"--view", {false, kNone, {"--view", "Raw"}}},
      {"--exposure", {false, kNone, {"--exposure", "1"}}},
      {"--ocio", {false, kNone, {"--ocio", "a.ocio"}}},
      {"--spp", {false, {"--planned-spp", "16"}, {"--spp", "32"}}},
      {"--planned-spp", {true, kNone, {"--planned-spp", "128"}}},
      {"--noise-threshold", {true, {"--planned-spp", "64"}, {"--noise-threshold", "0.1"}}},
      {"--min-spp", {true, {"--noise-threshold", "0.1"}, {"--min-spp", "64"}}},
      {"--time-limit", {false, {"--spp", "64"}, {"--time-limit", "5m"}}},
      {"--time-limit-total", {false, {"--spp", "64"}, {"--time-limit-total", "5m"}}},
      {"--seed", {true, kNone, {"--seed", "1"}}},
      {"--sampler", {true, kNone, {"--sampler", "sobol"}}},
      {"--filter", {true, {"--filter-width", "2"}, {"--filter", "box"}}},
      {"--filter-width", {true, kNone, {"--filter-width", "2"}}},
      {"--outliers", {true, kNone, {"--outliers", "trim"}}},
      {"--scene", {true, kNone, {"--scene", "1"}}},
      {"--variant", {true, kNone, {"--variant", "1"}}},
      {"--time", {true, kNone, {"--time", "1.5"}}},
      {"--shutter", {true, kNone, {"--shutter", "0,0.02"}}},
      {"--shutter-angle", {true, {"--shutter-angle", "90", "--fps", "24"}, {"--shutter-angle", "180"}}},
      {"--fps", {true, {"--shutter-angle", "90", "--fps", "24"}, {"--fps", "25"}}},
      {"--frames", {false, kNone, {"--frames", "1-2", "-o", "a##.png"}}}, // each frame is a --time of its own
      {"--force", {false, {"--checkpoint", "a.kacc"}, {"--force"}}},
      {"--camera", {true, kNone, {"--camera", "1"}}},
      {"--orbit", {true, kNone, {"--orbit", "1,2,3"}}},
      {"--orthographic", {true, {"--orbit", "1,2,3"}, {"--orthographic", "2"}}},
      {"--target", {true, {"--orbit", "1,2,3"}, {"--target", "1,0,0"}}},
      {"--turn", {true, kNone, {"--turn", "30"}}},
      {"--orbit-axis", {true, {"--turn", "30"}, {"--orbit-axis", "z"}}},
      {"--turntable", {true, kNone, {"--turntable", "4", "-o", "a##.png"}}}, // each frame has a --turn
      {"--turntable-animated",
       {false, {"--turntable", "4", "-o", "a##.png"}, {"--turntable-animated"}}}, // each frame has a --time
      {"--camera-path", {false, kNone, {"--camera-path", "a.json"}}},             // becomes the image's own camera
      {"--fov", {true, kNone, {"--fov", "30"}}},
      {"--backfaces", {true, kNone, {"--backfaces", "cull"}}},
      {"--f-stop", {true, kNone, {"--f-stop", "none"}}},
      {"--focal-length", {true, kLens, {"--focal-length", "50"}}},
      {"--focus-distance", {true, kLens, {"--focus-distance", "2"}}},
      {"--focus-pixel", {true, kLens, {"--focus-pixel", "1,2"}}},
      {"--aperture-blades", {true, kLens, {"--aperture-blades", "5"}}},
      {"--aperture-rotation", {true, kLens, {"--aperture-rotation", "5"}}},
      {"--anamorphic", {true, kLens, {"--anamorphic", "2"}}},
      {"--cats-eye", {true, kLens, {"--cats-eye", "0.5"}}},
      {"--env", {true, kNone, {"--env", "a.hdr"}}},
      {"--env-rotation", {true, kEnv, {"--env-rotation", "5"}}},
      {"--env-intensity", {true, kEnv, {"--env-intensity", "2"}}},
      {"--env-color", {true, kNone, {"--env-color", "0.2"}}},
      {"--studio", {true, kNone, {"--studio", "off"}}},
      {"--light-radius", {true, kNone, {"--light-radius", "0.1"}}},
      {"--sun-angle", {true, kNone, {"--sun-angle", "0.53"}}},
      {"--outlines", {true, kNone, {"--outlines"}}},
      {"--point-size", {true, kNone, {"--point-size", "3"}}},
      {"--background", {true, kNone, {"--background", "0.1,0.2,0.3"}}},
      {"--integrator", {true, kNone, {"--integrator", "ambient-occlusion"}}},
      {"--max-bounces", {true, kNone, {"--max-bounces", "3"}}},
      {"--max-diffuse-bounces", {true, kNone, {"--max-diffuse-bounces", "3"}}},
      {"--max-glossy-bounces", {true, kNone, {"--max-glossy-bounces", "3"}}},
      {"--max-transmission-bounces", {true, kNone, {"--max-transmission-bounces", "3"}}},
      {"--roulette-start", {true, kNone, {"--roulette-start", "5"}}},
      {"--direct-samples", {true, kNone, {"--direct-samples", "2"}}},
      {"--path-reuse", {true, kNone, {"--path-reuse", "4"}}},
      {"--reflection-samples", {true, kNone, {"--reflection-samples", "2"}}},
      {"--clamp-direct", {true, kNone, {"--clamp-direct", "5"}}},
      {"--clamp-indirect", {true, kNone, {"--clamp-indirect", "5"}}},
      {"--caustics", {true, kNone, {"--caustics", "off"}}},
      {"--sample-rates", {true, kNone, {"--sample-rates", "noise"}}},
      {"--light-paths", {true, kNone, {"--light-paths", "0.25"}}},
      {"--environment-filter", {true, kNone, {"--environment-filter", "0.5"}}},
      {"--photons", {true, kNone, {"--photons", "0.25"}}},
      {"--manifold-samples", {true, kNone, {"--manifold-samples", "2"}}},
      {"--guiding", {true, kNone, {"--guiding", "off"}}},
      {"--training-paths", {true, kNone, {"--training-paths", "4096"}}},
      {"--ao-distance", {true, kNone, {"--ao-distance", "1"}}},
      {"--tracer", {true, kNone, {"--tracer", "none"}}},
      {"--trace-depth", {true, kWhitted, {"--trace-depth", "3"}}},
      {"--max-reflections", {true, kWhitted, {"--max-reflections", "2"}}},
      {"--ambient", {true, kWhitted, {"--ambient", "sampled"}}},
      {"--light-samples", {true, kWhitted, {"--light-samples", "2x2"}}},
      {"--glossy-samples", {true, kWhitted, {"--glossy-samples", "2x2"}}},
      {"--whitted-cache", {false, kWhitted, {"--whitted-cache", "off"}}},
      {"--whitted-form", {false, kWhitted, {"--whitted-form", "recursive"}}},
      {"--accel", {true, kNone, {"--accel", "embree"}}},
      {"--accel-quality", {true, kNone, {"--accel-quality", "best"}}},
      {"--device", {false, kNone, {"--device", "host"}}},
      {"--device-memory", {false, {"--device", "host"}, {"--device-memory", "64M"}}},
      {"--threads", {false, kNone, {"--threads", "1"}}},
      {"--tile-size", {false, kNone, {"--tile-size", "8"}}},
      {"--schedule", {false, kNone, {"--schedule", "regions"}}},
      {"--batch-size", {false, kNone, {"--batch-size", "64"}}},
      {"--texture-memory", {false, kNone, {"--texture-memory", "1M"}}},
      {"--follow-links", {false, kNone, {"--follow-links"}}},
      {"--part", {false, kNone, {"--part", "1/2"}}},
      {"--tile-part", {false, kNone, {"--tile-part", "1/2"}}},
      {"--checkpoint", {false, kNone, {"--checkpoint", "a.kacc"}}},
      {"--checkpoint-every", {false, {"--checkpoint", "a.kacc"}, {"--checkpoint-every", "1m"}}},
      {"--progress", {false, kNone, {"--progress", "none"}}},
      {"--stats", {false, kNone, {"--stats", "a.json"}}},
      {"--tev", {false, kNone, {"--tev"}}},
      {"--tev-host", {false, kNone, {"--tev-host", "render-7"}}},
      {"--pixel", {false, kNone, {"--pixel", "1,1"}}},
      {"--sample", {false, {"--pixel", "1,1"}, {"--sample", "1"}}},
      {"--quiet", {false, kNone, {"--quiet"}}},
      {"--verbose", {false, kNone, {"--verbose"}}},
  };
  return kCases;
}

std::set<std::string> flags_of_help() {
  const Result<CommandLine> line = parse_command_line(std::vector<const char*>{"render", "--help"});
  const std::string text = std::get<PrintText>(line.value().command).text;
  const std::regex flag(R"((?:^|\n) {0,4}(?:-\w,)?(--[a-z][a-z0-9-]*))");
  std::set<std::string> names;
  for (auto it = std::sregex_iterator(text.begin(), text.end(), flag); it != std::sregex_iterator(); ++it)
    names.insert((*it)[1]);
  names.erase("--help");
  return names;
}

TEST(PixelSettings, EveryFlagOfRenderIsClassified) {
  const std::set<std::string> flags = flags_of_help();
  EXPECT_GT(flags.size(), 60U);
  for (const std::string& flag : flags)
    EXPECT_TRUE(flag_cases().contains(flag))
        << flag << ": do pixels depend on it? Then add it to pixel_settings(); in any case give it its line here";
  for (const auto& [flag, flag_case] : flag_cases()) EXPECT_TRUE(flags.contains(flag)) << flag << " is no flag";
}

TEST(PixelSettings, OnlyFlagsOfTheImageChangeSettings) {
  for (const auto& [flag, flag_case] : flag_cases()) {
    SCOPED_TRACE(flag);
    ASSERT_EQ(flag_case.changed.front(), flag);
    Words changed = flag_case.with;
    changed.insert(changed.end(), flag_case.changed.begin(), flag_case.changed.end());
    const std::string before = settings(flag_case.with), after = settings(changed);
    if (flag_case.of_image)
      EXPECT_NE(before, after);
    else
      EXPECT_EQ(before, after);
  }
}

TEST(PixelSettings, DefaultsEqualExplicitValues) {
  EXPECT_EQ(settings({}), settings({"--seed",
                                    "0",
                                    "--spp",
                                    "64",
                                    "--size",
                                    "1280x720",
                                    "--crop",
                                    "0,0,1280,720",
                                    "--aov",
                                    "beauty,samples",
                                    "--filter-width",
                                    "1.5",
                                    "--max-transmission-bounces",
                                    "16",
                                    "--accel",
                                    "kdtree",
                                    "--camera",
                                    "0",
                                    "--background",
                                    "env",
                                    "--guiding",
                                    "auto"}));
  EXPECT_EQ(settings({"--shutter-angle", "180", "--fps", "25"}), settings({"--shutter", "0,0.02"}));
  EXPECT_EQ(settings({"--noise-threshold", "0.1"}),
            settings({"--noise-threshold", "0.1", "--min-spp", "32", "--spp", "1024", "--aov", "samples"}));
}

TEST(PixelSettings, DependOnTheContentsOfTheEnvironment) {
  EXPECT_NE(settings({"--env", "a.hdr"}, 1), settings({"--env", "a.hdr"}, 2));
  EXPECT_EQ(settings({"--env", "a.hdr"}, 1), settings({"--env", "elsewhere/b.hdr"}, 1));
}

TEST(PixelSettings, DifferencesAreListed) {
  const auto refusal = [](const std::string& before, const std::string& now) {
    AccumulationIdentity file, here;
    file.image = before;
    here.image = now;
    const Result<void> same = check_same_render(file, "a.kacc", here);
    return same.ok() ? "" : same.error().message;
  };
  EXPECT_EQ(refusal(settings({}), settings({})), "");
  EXPECT_EQ(
      refusal(settings({"--clamp-direct", "0.1"}), settings({"--seed", "2"})),
      "a.kacc: belongs to another render (--clamp-direct: 0.1 in the file, none here; --seed: 0 in the file, 2 here); "
      "use the same settings, or another file name");
  const std::string many =
      refusal(settings({}), settings({"--seed", "2", "--fov", "3", "--light-radius", "1", "--f-stop", "4"}));
  EXPECT_NE(many.find("; and 1 more); "), std::string::npos) << many;
  EXPECT_NE(refusal("junk", "{}").find("settings: junk in the file, {} here"), std::string::npos)
      << refusal("junk", "{}");
}

TEST(Version, IdentityHasTheHashOfTheSources) {
  EXPECT_TRUE(std::regex_match(program_identity(), std::regex(R"(Kindling \S+ \(sources [0-9a-f]{16}, .+\))")))
      << program_identity();
}

} // namespace
} // namespace kindling::app
