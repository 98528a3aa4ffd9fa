// The flags of `kindling scaling`.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/command_flags.h"
#include "renderer/app/flags/device_flag.h"
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
constexpr uint32_t kQuickRepeat = 1;

// The flags of `kindling render` that affect the image or its cost, without --spp, which has
// another default.
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
                                           "--point-size",
                                           "--follow-links",
                                           "--camera",
                                           "--orbit",
                                           "--target",
                                           "--fov",
                                           "--backfaces",
                                           "--env",
                                           "--env-rotation",
                                           "--env-intensity",
                                           "--env-color",
                                           "--studio",
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
                                           "--light-paths",
                                           "--photons",
                                           "--environment-filter",
                                           "--manifold-samples",
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

// "8": up to 8; "1,2,7": these counts, and 1.
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

std::string join_schedules(const std::vector<Schedule>& schedules) {
  std::string text;
  for (const Schedule schedule : schedules) text += (text.empty() ? "" : ",") + std::string(schedule_name(schedule));
  return text;
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
      "Numbers of threads to measure: 1 to 4, powers of two and MAX, or a list, to which 1 is added; more threads than "
      "cores are allowed [MAX is the number of cores]",
      [&o](auto text) { return set_threads(text, o); });
  flags.value("--accel", "SPEC[,SPEC]...",
              fmt::format("Accelerators, NAME[:QUALITY][:robust|:non-robust][:SIMD] as for 'kindling shootout' [{}]",
                          join_variants(o.accelerators)),
              [&o](auto text) { return store(parse_accelerator_variants(text), o.accelerators); });
  flags.value(
      "--schedule", "NAME[,NAME]",
      fmt::format("Distribution of work: tiles to whichever thread is free, regions: one rectangle per thread [{}]",
                  join_schedules(o.schedules)),
      [&o](auto text) { return set_schedules(text, o.schedules); });
  add_measured_device_flag(flags, o.device,
                           "Measure a device too, alone and with the processor on one frame, with the images of the "
                           "first kd-tree of --accel: an NVIDIA GPU, or the kernels for GPUs run on the processor (a "
                           "test)");
  flags.value("--repeat", "N",
              fmt::format("Rounds over all combinations [{}; {} with --quick]", o.repeat, kQuickRepeat),
              [&o](auto text) { return store(parse_integer(text, 1, 1000), o.repeat); });
  flags.value(
      "--seconds", "S",
      fmt::format("Choose the samples per pixel so that one thread takes about S seconds, instead of --spp [{:g}; {:g} "
                  "with --quick]",
                  kSeconds, kQuickSeconds),
      [&o](auto text) { return store(parse_number(text, 0.01, 1e6), o.seconds); });
  flags.value(
      "--spp", "N",
      fmt::format("Samples per pixel; the maximum with --noise-threshold [by --seconds; {} with --noise-threshold]",
                  kDefaultMaxSamplesPerPixel),
      [&o](auto text) { return store(parse_integer(text, 1, kUnlimitedSamplesPerPixel), o.image.spp); });
  flags.toggle("--quick", fmt::format("A first estimate: --repeat {} --seconds {:g}", kQuickRepeat, kQuickSeconds),
               o.quick);
  flags.only(kImageFlags);
  add_render_flags(flags, o.image);
  flags.only({});
  flags.group("Reports");
  flags.value("--json", "FILE", "Write all measurements as JSON [none]",
              [&o](auto text) { return set_path(text, o.json_file); });
  flags.value("--csv", "FILE",
              "Write one line for each scene, accelerator, schedule or phase, and number of threads [none]",
              [&o](auto text) { return set_path(text, o.csv_file); });
  flags.value("--svg", "FILE", "Write curves of speed-up and efficiency [none]",
              [&o](auto text) { return set_path(text, o.svg_file); });
}

Result<void> check_scaling_flags(const FlagSet& flags, ScalingOptions& o) {
  if (o.scene_files.empty())
    return usage_error("no scene; use 'kindling scaling SCENE... [flags]' with .gltf or .glb files");
  o.image.scene_file = o.scene_files.front();
  if (Result<void> checked = check_render_flags(flags, o.image); !checked.ok()) return checked;
  if (flags.given("--spp") && flags.given("--seconds")) return usage_error("--spp and --seconds: give one of them");
  // A named Whitted tracer implies an accelerator.
  if (o.image.tracer && !flags.given("--accel")) {
    o.accelerators.resize(1);
    o.accelerators.front().kind = o.image.accelerator;
  }
  if (o.device && std::none_of(o.accelerators.begin(), o.accelerators.end(),
                               [](const AcceleratorVariant& variant) { return variant.kind == accel::Kind::kdtree; }))
    return usage_error("--device: a device renders with the kd-tree alone; use --accel kdtree");
  if (o.quick && !flags.given("--repeat")) o.repeat = kQuickRepeat;
  // Adaptive sampling chooses its samples itself.
  const bool counted = flags.given("--spp") || o.image.adaptive.enabled();
  if (counted && flags.given("--seconds")) return usage_error("--seconds: has no meaning with --noise-threshold");
  if (!counted && !o.seconds) o.seconds = o.quick ? kQuickSeconds : kSeconds;
  const std::array files{&o.json_file, &o.csv_file, &o.svg_file};
  for (size_t i = 0; i < files.size(); ++i)
    for (size_t j = 0; j < i; ++j)
      if (!files[i]->empty() && files[i]->lexically_normal() == files[j]->lexically_normal())
        return usage_error(fmt::format("{}: two reports cannot have the same name", files[i]->string()));
  return {};
}

} // namespace kindling::app
