// Parsing of arguments into options: values, defaults, and refused combinations.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/parse_command_line.h"
#include "renderer/app/options/options.h"

#include <gtest/gtest.h>

namespace kindling::app {
namespace {

RenderOptions render_options(std::vector<const char*> flags) {
  std::vector<const char*> arguments{"render", "a.glb"};
  arguments.insert(arguments.end(), flags.begin(), flags.end());
  Result<CommandLine> line = parse_command_line(arguments);
  EXPECT_TRUE(line.ok()) << (line.ok() ? "" : line.error().message);
  return line.ok() ? std::get<RenderOptions>(line.value().command) : RenderOptions{};
}

std::string refusal(std::vector<const char*> arguments) {
  const Result<CommandLine> line = parse_command_line(arguments);
  if (line.ok()) return "accepted";
  EXPECT_EQ(line.error().kind, ErrorKind::usage);
  return line.error().message;
}

TEST(Options, HaveDefaults) {
  const RenderOptions options = render_options({});
  EXPECT_EQ(options.scene_file, "a.glb");
  EXPECT_EQ(options.samples_per_pixel(), 64U);
  EXPECT_EQ(options.integrator.max_bounces, 8);
  EXPECT_EQ(options.accelerator, accel::Kind::kdtree);
  EXPECT_EQ(options.sampler, SamplerKind::blue_noise);
  EXPECT_EQ(options.filter.kind, FilterKind::blackman_harris);
  EXPECT_TRUE(options.outputs.empty());
  EXPECT_EQ(render_options({"--guiding", "auto"}).guiding, Guiding::automatic);
  EXPECT_EQ(render_options({"--guiding", "on"}).guiding, Guiding::on);
  EXPECT_EQ(render_options({"--guiding", "off"}).guiding, Guiding::off);
  EXPECT_FALSE(options.chooses_light_paths);
  EXPECT_EQ(options.integrator.light_paths, 0.0f);
  EXPECT_TRUE(options.exr_half);
  EXPECT_EQ(options.progress, ProgressMode::automatic);
}

TEST(Options, StoreAllValues) {
  const RenderOptions options = render_options({"-o",
                                                "x.png",
                                                "--output=y.exr",
                                                "--spp",
                                                "16",
                                                "--size",
                                                "320x200",
                                                "--crop=1,2,30,40",
                                                "--camera",
                                                "Side",
                                                "--time",
                                                "1.5",
                                                "--env",
                                                "e.hdr",
                                                "--env-rotation",
                                                "-90",
                                                "--env-intensity",
                                                "2",
                                                "--accel",
                                                "kdtree",
                                                "--accel-quality",
                                                "best",
                                                "--integrator",
                                                "ambient-occlusion",
                                                "--clamp-indirect",
                                                "10",
                                                "--caustics",
                                                "regularized",
                                                "--outliers",
                                                "trim",
                                                "--seed",
                                                "9",
                                                "--sampler",
                                                "sobol",
                                                "--filter",
                                                "mitchell",
                                                "--filter-width",
                                                "3",
                                                "--threads",
                                                "3",
                                                "--tile-size",
                                                "64",
                                                "--aov",
                                                "albedo,depth",
                                                "--aov",
                                                "normal",
                                                "--exr-float",
                                                "--png-bits",
                                                "16",
                                                "--view",
                                                "Raw",
                                                "--exposure",
                                                "-1",
                                                "--stats",
                                                "s.json",
                                                "--progress",
                                                "plain",
                                                "-v",
                                                "--batch-size",
                                                "128",
                                                "--time-limit",
                                                "5m"});
  EXPECT_EQ(options.outputs, (std::vector<std::filesystem::path>{"x.png", "y.exr"}));
  EXPECT_EQ(options.samples_per_pixel(), 16U);
  EXPECT_EQ(*options.size_px, V2i(320, 200));
  EXPECT_EQ(options.crop->max, V2i(30, 40));
  EXPECT_EQ(options.camera, "Side");
  EXPECT_EQ(*options.time_s, 1.5);
  EXPECT_EQ(options.env_file, "e.hdr");
  EXPECT_EQ(options.env_rotation_deg, -90.0);
  EXPECT_EQ(options.accelerator, accel::Kind::kdtree);
  EXPECT_EQ(options.quality, accel::Quality::best);
  EXPECT_EQ(options.integrator.kind, IntegratorKind::ambient_occlusion);
  EXPECT_EQ(options.integrator.clamp_indirect, 10.0f);
  EXPECT_EQ(options.integrator.caustics, Caustics::regularized);
  EXPECT_EQ(options.outliers, Outliers::trim);
  EXPECT_EQ(options.sampler, SamplerKind::sobol);
  EXPECT_EQ(options.filter.kind, FilterKind::mitchell);
  EXPECT_EQ(options.filter.width, 3.0f);
  EXPECT_EQ(options.tile_size_px, 64);
  for (const Aov aov : {Aov::albedo, Aov::depth, Aov::normal}) EXPECT_TRUE(options.aovs.contains(aov));
  EXPECT_FALSE(options.aovs.contains(Aov::position));
  EXPECT_FALSE(options.exr_half);
  EXPECT_EQ(options.png_bits, 16);
  EXPECT_EQ(options.exposure_stops, -1.0);
  EXPECT_EQ(options.integrator.batch_size, 128U);
  EXPECT_EQ(*options.time_limit_s, 300.0);
  EXPECT_TRUE(options.verbose);
}

TEST(Options, DirectSamplesAreChosenOrGiven) {
  EXPECT_TRUE(render_options({}).chooses_direct_samples);
  EXPECT_TRUE(render_options({"--direct-samples", "3", "--direct-samples", "auto"}).chooses_direct_samples);
  EXPECT_EQ(render_options({"--direct-samples", "3", "--direct-samples", "auto"}).integrator.direct_samples, 1);
  for (const char* samples : {"1", "16"}) {
    const RenderOptions options = render_options({"--direct-samples", samples});
    EXPECT_FALSE(options.chooses_direct_samples) << samples;
    EXPECT_EQ(options.integrator.direct_samples, std::stoi(samples));
  }
  for (const char* samples : {"0", "17", "-1", "2.5", "many", ""})
    EXPECT_EQ(refusal({"render", "a.glb", "--direct-samples", samples}),
              "--direct-samples: '" + std::string(samples) + "' is neither auto nor a whole number from 1 to 16");
}

TEST(Options, ReflectionSamplesAreChosenOrGiven) {
  EXPECT_TRUE(render_options({}).chooses_reflection_samples);
  EXPECT_TRUE(render_options({"--reflection-samples", "3", "--reflection-samples", "auto"}).chooses_reflection_samples);
  for (const char* samples : {"0", "4"}) {
    const RenderOptions options = render_options({"--reflection-samples", samples});
    EXPECT_FALSE(options.chooses_reflection_samples) << samples;
    EXPECT_EQ(options.integrator.reflection_samples, std::stoi(samples));
  }
  for (const char* samples : {"5", "-1", "some"})
    EXPECT_EQ(refusal({"render", "a.glb", "--reflection-samples", samples}),
              "--reflection-samples: '" + std::string(samples) + "' is neither auto nor a whole number from 0 to 4");
}

TEST(Options, PathReuseIsChosenOrGiven) {
  EXPECT_TRUE(render_options({}).chooses_path_reuse);
  EXPECT_TRUE(render_options({"--path-reuse", "8", "--path-reuse", "auto"}).chooses_path_reuse);
  EXPECT_EQ(render_options({"--path-reuse", "8", "--path-reuse", "auto"}).integrator.path_reuse, 1);
  for (const char* count : {"1", "8"}) {
    EXPECT_FALSE(render_options({"--path-reuse", count}).chooses_path_reuse);
    EXPECT_EQ(render_options({"--path-reuse", count}).integrator.path_reuse, std::stoi(count));
  }
  for (const char* count : {"0", "3", "16", "many", ""})
    EXPECT_EQ(refusal({"render", "a.glb", "--path-reuse", count}),
              "--path-reuse: '" + std::string(count) + "' is not auto, 1, 2, 4 or 8");
}

TEST(Options, LightPathsAreChosenOrGiven) {
  EXPECT_TRUE(render_options({"--light-paths", "0.5", "--light-paths", "auto"}).chooses_light_paths);
  EXPECT_EQ(render_options({"--light-paths", "0.5", "--light-paths", "auto"}).integrator.light_paths, 0.0f);
  for (const char* fraction : {"0", "0.25", "1"}) {
    const RenderOptions options = render_options({"--light-paths", fraction});
    EXPECT_FALSE(options.chooses_light_paths) << fraction;
    EXPECT_EQ(options.integrator.light_paths, std::stof(fraction));
  }
}

TEST(Options, PhotonsAreChosenOrGiven) {
  EXPECT_TRUE(render_options({}).chooses_photons);
  EXPECT_TRUE(render_options({"--photons", "0.5", "--photons", "auto"}).chooses_photons);
  EXPECT_EQ(render_options({"--photons", "0.5", "--photons", "auto"}).integrator.photons, 0.0f);
  EXPECT_FALSE(render_options({"--photons", "auto", "--photons", "0.25"}).chooses_photons);
  EXPECT_EQ(render_options({"--photons", "auto", "--photons", "0.25"}).integrator.photons, 0.25f);
  EXPECT_EQ(refusal({"render", "a.glb", "--photons", "many"}),
            "--photons: 'many' is neither auto nor a number from 0 to 1");
}

TEST(Options, TotalTimeLimitsLimitTheRender) {
  const RenderOptions options = render_options({"--time-limit-total", "5s"});
  EXPECT_EQ(*options.time_limit_total_s, 5.0);
  EXPECT_EQ(*options.time_limit_s, 5.0); // until it is known when the render begins
  EXPECT_EQ(options.samples_per_pixel(), kUnlimitedSamplesPerPixel);
}

TEST(Options, TurnsHaveACenter) {
  EXPECT_FALSE(render_options({}).turn);
  const RenderOptions turned = render_options({"--turn", "-30", "--target", "1,2,3", "--orbit-axis", "z"});
  EXPECT_EQ(turned.turn->angle_deg, -30.0);
  EXPECT_EQ(turned.turn->axis, V3f(0.0f, 0.0f, 1.0f));
  EXPECT_EQ(turned.turn->around, V3f(1.0f, 2.0f, 3.0f));
  EXPECT_FALSE(render_options({"--turn", "5"}).turn->around);
}

TEST(Options, AcceptNegativeValues) {
  const RenderOptions options = render_options({"--orbit", "-140,50,5", "--target", "-1,0,-2", "--fov", "30"});
  EXPECT_EQ(*options.orbit, V3f(-140.0f, 50.0f, 5.0f));
  EXPECT_EQ(options.target, V3f(-1.0f, 0.0f, -2.0f));
  EXPECT_EQ(*options.yfov_deg, 30.0);
}

TEST(Options, UseTheLastValueOfAFlag) {
  EXPECT_EQ(render_options({"--spp", "4", "--spp", "8"}).samples_per_pixel(), 8U);
  const RenderOptions options = render_options({"--background", "transparent", "--background", "1,0,0"});
  EXPECT_FALSE(options.integrator.transparent_background);
  EXPECT_EQ(*options.integrator.background, Rgb(1.0f, 0.0f, 0.0f));
}

TEST(Options, SeparateBounceLimitsFollowTheTotal) {
  const RenderOptions all = render_options({"--max-bounces", "32"});
  EXPECT_EQ(all.integrator.max_diffuse_bounces, 32);
  EXPECT_EQ(all.integrator.max_glossy_bounces, 32);
  EXPECT_EQ(all.integrator.max_transmission_bounces, 40); // a glass has many surfaces
  const RenderOptions one = render_options({"--max-diffuse-bounces", "1", "--max-bounces", "4"});
  EXPECT_EQ(one.integrator.max_diffuse_bounces, 1);
  EXPECT_EQ(one.integrator.max_glossy_bounces, 4);
}

TEST(Options, TimeLimitAloneDoesNotLimitSamples) {
  EXPECT_EQ(render_options({"--time-limit", "10"}).samples_per_pixel(), kUnlimitedSamplesPerPixel);
  EXPECT_EQ(render_options({"--time-limit", "10", "--spp", "5"}).samples_per_pixel(), 5U);
}

TEST(Options, AdaptiveSampling) {
  EXPECT_FALSE(render_options({}).adaptive.enabled());
  EXPECT_FALSE(render_options({"--noise-threshold", "0"}).adaptive.enabled());
  EXPECT_EQ(render_options({"--noise-threshold", "0"}).samples_per_pixel(), kDefaultSamplesPerPixel);
  const RenderOptions options = render_options({"--noise-threshold", "0.05", "--min-spp", "64"});
  EXPECT_EQ(options.adaptive.noise_threshold, 0.05);
  EXPECT_EQ(options.adaptive.min_samples_per_pixel, 64U);
  EXPECT_EQ(options.samples_per_pixel(), kDefaultMaxSamplesPerPixel);
}

TEST(Options, RefuseWrongAdaptiveSampling) {
  const auto refused = [](std::vector<const char*> flags) {
    flags.insert(flags.begin(), {"render", "a.glb"});
    return refusal(std::move(flags));
  };
  for (const char* bad : {"-0.1", "1.5", "nan", "much"}) {
    const std::string message = refused({"--noise-threshold", bad});
    EXPECT_TRUE(message.starts_with("--noise-threshold: '" + std::string(bad) + "'")) << message;
  }
  const std::string few = refused({"--noise-threshold", "0.1", "--min-spp", "15"});
  EXPECT_TRUE(few.starts_with("--min-spp: '15'")) << few;
  EXPECT_EQ(refused({"--min-spp", "32"}), "--min-spp: has no meaning without --noise-threshold above 0");
  EXPECT_EQ(refused({"--noise-threshold", "0.1", "--min-spp", "65", "--spp", "64"}),
            "--noise-threshold: --spp 64 is below --min-spp 65; use a larger --spp or a smaller --min-spp");
  EXPECT_EQ(refused({"--noise-threshold", "0.1", "--spp", "20"}),
            "--noise-threshold: --spp 20 is below --min-spp 32; use a larger --spp or a smaller --min-spp");
}

TEST(Options, QuoteTheCommandLineForAShell) {
  const Result<CommandLine> line = parse_command_line(std::vector<const char*>{"render", "my scene.glb", "--spp", "4"});
  ASSERT_TRUE(line.ok());
  EXPECT_EQ(line.value().text, "kindling render 'my scene.glb' --spp 4");
}

TEST(Options, RefuseWrongCombinations) {
  EXPECT_EQ(refusal({"render", "a.glb", "--env-rotation", "3"}), "--env-rotation: has no meaning without --env");
  EXPECT_EQ(refusal({"render", "a.glb", "--target", "0,0,0"}),
            "--target: has no meaning without --orbit, --turn or --turntable");
  EXPECT_EQ(refusal({"render", "a.glb", "--time-limit", "3s", "--time-limit-total", "5s"}),
            "--time-limit and --time-limit-total: give one of them");
  EXPECT_EQ(refusal({"render", "a.glb", "--guiding", "off", "--training-paths", "3"}),
            "--training-paths: has no meaning with --guiding off");
  EXPECT_EQ(refusal({"render", "a.glb", "--orbit", "0,90,1", "--camera", "0"}),
            "--orbit and --camera: give one of them");
  EXPECT_EQ(refusal({"render", "a.glb", "--orbit", "0,90,-1"}), "--orbit: the radius -1 is negative; use 0 or more");
  EXPECT_EQ(refusal({"render", "a.glb", "--orbit", "0,90,3e18"}),
            "--orbit: the radius 3e+18 is out of range; use 0 to 1e+18");
  EXPECT_EQ(refusal({"render", "a.glb", "--orbit", "0,90,1", "--target", "0,-3e38,0"}),
            "--target: '0,-3e+38,0' is out of range; use coordinates from -1e+18 to 1e+18");
  EXPECT_EQ(refusal({"render", "a.glb", "--env", "a.exr", "--env-rotation", "1e39"}),
            "--env-rotation: '1e39' is out of range; use -1e+06 to 1e+06");
  EXPECT_EQ(refusal({"render", "a.glb", "--light-radius", "1e-42"}),
            "--light-radius: '1e-42' is closer to 0 than single precision allows; use 0 to 1e+09");
  EXPECT_EQ(refusal({"render", "a.glb", "-q", "-v"}), "--quiet and --verbose: give one of them");
  EXPECT_EQ(refusal({"render", "a.glb", "--guiding", "maybe"}),
            "--guiding: unknown guiding 'maybe'; use on, off or auto");
  EXPECT_EQ(refusal({"render", "a.glb", "--guiding"}), "--guiding: needs a value");
  for (const char* fraction : {"some", "1.5", "-0.1", "nan"})
    EXPECT_EQ(refusal({"render", "a.glb", "--light-paths", fraction}),
              "--light-paths: '" + std::string(fraction) + "' is neither auto nor a number from 0 to 1");
  EXPECT_EQ(refusal({"render", "a.glb", "--tile-size", "20"}),
            "--tile-size: '20' is not a multiple of 8; use one, such as 16 or 32");
  EXPECT_EQ(refusal({"render", "a.glb", "--batch-size", "65"}),
            "--batch-size: '65' is not a multiple of 64; use one, such as 128 or 256");
}

TEST(Options, InfoTopics) {
  const Result<CommandLine> line =
      parse_command_line(std::vector<const char*>{"info", "--list-scenes", "a.glb", "--json"});
  ASSERT_TRUE(line.ok());
  const auto& info = std::get<InfoOptions>(line.value().command);
  EXPECT_EQ(info.topic, InfoTopic::scenes);
  EXPECT_TRUE(info.json);
  EXPECT_EQ(info.scene_file, "a.glb");
}

TEST(Options, HelpHintsNameTheCommand) {
  EXPECT_EQ(help_hint(std::vector<const char*>{"info", "x"}), " (try 'kindling info --help')");
  EXPECT_EQ(help_hint({}), " (try 'kindling --help')");
}

} // namespace
} // namespace kindling::app
