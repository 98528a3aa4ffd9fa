// The flags of `kindling scaling`.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/command_flags.h"
#include "renderer/app/flags/flag_set.h"
#include "renderer/app/flags/scene_flags.h"
#include "renderer/app/options/options.h"
#include "renderer/app/text/parse_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace kindling::app {

namespace {

constexpr int kMaxThreads = 1024;
constexpr double kSeconds = 5.0, kQuickSeconds = 2.0;

// Those of `kindling render` that shape the image or its cost, but for --spp, which has another default.
const std::vector<std::string> kImageFlags{"--size",
                                           "--scale",
                                           "--crop",
                                           "--noise-threshold",
                                           "--min-spp",
                                           "--seed",
                                           "--sampler",
                                           "--filter",
                                           "--filter-width",
                                           "--outliers",
                                           "--scene",
                                           "--variant",
                                           "--time",
                                           "--camera",
                                           "--orbit",
                                           "--target",
                                           "--fov",
                                           "--env",
                                           "--env-rotation",
                                           "--env-intensity",
                                           "--env-color",
                                           "--light-radius",
                                           "--sun-angle",
                                           "--background",
                                           "--f-stop",
                                           "--focal-length",
                                           "--focus-distance",
                                           "--focus-pixel",
                                           "--aperture-blades",
                                           "--aperture-rotation",
                                           "--anamorphic",
                                           "--cats-eye",
                                           "--shutter",
                                           "--shutter-angle",
                                           "--fps",
                                           "--integrator",
                                           "--max-bounces",
                                           "--max-diffuse-bounces",
                                           "--max-glossy-bounces",
                                           "--max-transmission-bounces",
                                           "--roulette-start",
                                           "--clamp-direct",
                                           "--clamp-indirect",
                                           "--caustics",
                                           "--guiding",
                                           "--ao-distance",
                                           "--tracer",
                                           "--trace-depth",
                                           "--max-reflections",
                                           "--ambient",
                                           "--light-samples",
                                           "--glossy-samples",
                                           "--whitted-cache",
                                           "--whitted-form",
                                           "--tile-size",
                                           "--batch-size",
                                           "--texture-memory",
                                           "--quiet",
                                           "--verbose"};

// "8": up to 8; "1,2,7": these, and one.
Result<void> set_threads(std::string_view text, ScalingOptions& o) {
  Result<std::vector<std::string>> words = parse_list(text);
  if (!words.ok()) return words.error();
  std::vector<int> counts;
  for (const std::string& word : words.value()) {
    Result<int64_t> count = parse_integer(word, 1, kMaxThreads);
    if (!count.ok()) return count.error();
    counts.push_back(static_cast<int>(count.value()));
  }
  o.thread_counts.clear();
  o.max_threads = 0;
  if (counts.size() == 1) {
    o.max_threads = counts.front();
    return {};
  }
  counts.push_back(1);
  std::sort(counts.begin(), counts.end());
  counts.erase(std::unique(counts.begin(), counts.end()), counts.end());
  o.thread_counts = std::move(counts);
  return {};
}

Result<void> set_schedules(std::string_view text, std::vector<Schedule>& schedules) {
  Result<std::vector<std::string>> words = parse_list(text);
  if (!words.ok()) return words.error();
  schedules.clear();
  for (const std::string& word : words.value()) {
    Schedule schedule = Schedule::tiles;
    if (Result<void> chosen = choose(schedule_from_name(word), schedule, "schedule", word, {"tiles", "regions"});
        !chosen.ok())
      return chosen;
    if (std::count(schedules.begin(), schedules.end(), schedule) > 0)
      return Error{ErrorKind::usage, fmt::format("{} is given twice", word)};
    schedules.push_back(schedule);
  }
  return {};
}

} // namespace

void add_scaling_flags(FlagSet& flags, ScalingOptions& o) {
  flags.group("Scaling");
  flags.value(
      "--threads", "MAX|N,N...",
      "Numbers of threads: 1 to 4, powers of two and MAX, or these and 1; more than there are cores are allowed "
      "[MAX is all cores]",
      [&o](auto text) { return set_threads(text, o); });
  flags.value("--accel", "SPEC[,SPEC]...",
              "Accelerators, NAME[:QUALITY][:robust|:non-robust][:SIMD] as for 'kindling shootout' [kdtree,embree]",
              [&o](auto text) { return store(parse_accelerator_variants(text), o.accelerators); });
  flags.value("--schedule", "NAME[,NAME]",
              "tiles for whoever is free, regions: a rectangle for each thread [tiles,regions]",
              [&o](auto text) { return set_schedules(text, o.schedules); });
  flags.value("--repeat", "N", "Rounds over all of these [3; 1 with --quick]",
              [&o](auto text) { return store(parse_integer(text, 1, 1000), o.repeat); });
  flags.value("--seconds", "S",
              "In place of --spp: as many samples per pixel as take one thread about S seconds [5; 2 with --quick]",
              [&o](auto text) { return store(parse_number(text, 0.01, 1e6), o.seconds); });
  flags.value("--spp", "N",
              "Samples per pixel, at most with --noise-threshold [by --seconds; 1024 with --noise-threshold]",
              [&o](auto text) { return store(parse_integer(text, 1, kUnlimitedSamplesPerPixel), o.image.spp); });
  flags.toggle("--quick", "A first answer: --repeat 1 --seconds 2", o.quick);
  flags.only(kImageFlags);
  add_render_flags(flags, o.image);
  flags.only({});
  flags.group("Reports");
  flags.value("--json", "FILE", "Everything that was measured [none]",
              [&o](auto text) { return set_path(text, o.json_file); });
  flags.value("--csv", "FILE", "One line for each scene, accelerator, schedule or phase, and number of threads [none]",
              [&o](auto text) { return set_path(text, o.csv_file); });
  flags.value("--svg", "FILE", "Curves of speed-up and efficiency [none]",
              [&o](auto text) { return set_path(text, o.svg_file); });
}

Result<void> check_scaling_flags(const FlagSet& flags, ScalingOptions& o) {
  if (o.scene_files.empty())
    return usage_error("no scene; use 'kindling scaling SCENE... [flags]' with .gltf or .glb files");
  o.image.scene_file = o.scene_files.front();
  if (Result<void> checked = check_render_flags(flags, o.image); !checked.ok()) return checked;
  if (flags.given("--spp") && flags.given("--seconds")) return usage_error("--spp and --seconds: give one of them");
  // The preset of a Whitted tracer has an accelerator of its own.
  if (o.image.tracer && !flags.given("--accel")) {
    o.accelerators.resize(1);
    o.accelerators.front().kind = o.image.accelerator;
  }
  if (o.quick && !flags.given("--repeat")) o.repeat = 1;
  // How many samples adaptive sampling takes is its own affair.
  const bool counted = flags.given("--spp") || o.image.adaptive.enabled();
  if (counted && flags.given("--seconds")) return usage_error("--seconds: has no meaning with --noise-threshold");
  if (!counted && !o.seconds) o.seconds = o.quick ? kQuickSeconds : kSeconds;
  const std::array files{&o.json_file, &o.csv_file, &o.svg_file};
  for (size_t i = 0; i < files.size(); ++i)
    for (size_t j = 0; j < i; ++j)
      if (!files[i]->empty() && files[i]->lexically_normal() == files[j]->lexically_normal())
        return usage_error(fmt::format("{}: two reports cannot have one name", files[i]->string()));
  return {};
}

} // namespace kindling::app
