// The flags of `kindling shootout`.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/command_flags.h"
#include "renderer/app/flags/device_flag.h"
#include "renderer/app/flags/flag_set.h"
#include "renderer/app/flags/scene_flags.h"
#include "renderer/app/options/options.h"
#include "renderer/app/text/parse_values.h"
#include "renderer/app/text/text_format.h"

#include <fmt/format.h>

#include <array>

namespace kindling::app {

namespace {

std::optional<ShootoutClock> clock_from_name(std::string_view name) {
  for (const ShootoutClock clock : {ShootoutClock::wall, ShootoutClock::cpu})
    if (name == clock_name(clock)) return clock;
  return std::nullopt;
}

// Refuses a plain number, which is meant as a count.
Result<void> set_rays_file(std::string_view text, std::filesystem::path& target) {
  if (parse_number(text).ok())
    return usage_error(
        fmt::format("'{0}' is a number, and this flag names a file to record rays to; use --rays-per-kind "
                    "{0} for the count, or ./{0} for a file of this name",
                    text));
  return set_path(text, target);
}

// FILE[,OPTIONS], where the name of the file has no comma.
Result<void> add_plugin(std::string_view text, std::vector<PluginSpec>& plugins) {
  const size_t comma = text.find(',');
  PluginSpec plugin;
  if (Result<void> set = set_path(text.substr(0, comma), plugin.file); !set.ok()) return set;
  if (comma != std::string_view::npos) plugin.options = text.substr(comma + 1);
  for (const PluginSpec& other : plugins)
    if (other.name() == plugin.name())
      return usage_error(fmt::format("'{}' is given twice; reports name plugins by file and options", plugin.name()));
  plugins.push_back(std::move(plugin));
  return {};
}

} // namespace

void add_shootout_flags(FlagSet& flags, ShootoutOptions& o) {
  flags.group("Race");
  flags.value(
      "--accel", "SPEC[,SPEC]...",
      fmt::format("Accelerators, NAME[:QUALITY][:robust|:non-robust][:SIMD]: embree, kdtree or brute-force; fast, "
                  "balanced or best; SIMD is portable, avx2 or avx512 for kdtree and sse2, sse4.2, avx, avx2 or "
                  "avx512 for embree, the processor's best if left out; all are compared with the first [{}]",
                  join_variants(o.accelerators)),
      [&o](auto text) { return store(parse_accelerator_variants(text), o.accelerators); });
  flags.repeated("--plugin", "FILE[,OPTIONS]",
                 "Race the accelerator of this shared library too, in a process of its own; OPTIONS are passed to it. "
                 "accel/plugin has its C interface. May be given several times [none]",
                 [&o](auto text) { return add_plugin(text, o.plugins); });
  flags.value("--plugin-time-limit", "TIME",
              fmt::format("Longest time of one build or one pass over rays by a plugin, after which it is out of the "
                          "race: seconds, or 90s, 5m [{}]",
                          format_duration(o.plugin_time_limit_s)),
              [&o](auto text) { return store(parse_duration(text), o.plugin_time_limit_s); });
  add_measured_device_flag(flags, o.device,
                           "Race a device too, which traces all rays of a kind in one launch with the first kd-tree of "
                           "--accel: an NVIDIA GPU, "
                           "or the kernels for GPUs run on the processor (a test)");
  flags.value("--isa", "SIMD",
              "Race as on a processor with no more than this instruction set: sse2, sse4.2, avx, avx2 or avx512 [the "
              "processor's best]",
              [&o](auto text) -> Result<void> {
                const Result<accel::SimdTarget> isa = parse_instruction_set(text);
                if (!isa.ok()) return isa.error();
                o.isa = isa.value();
                return {};
              });
  flags.value("--rays-per-kind", "N", fmt::format("Number of rays of each kind [{}]", o.rays_per_kind),
              [&o](auto text) { return store(parse_integer(text, 1, 1 << 26), o.rays_per_kind); });
  flags.value("--batch-size", "N", fmt::format("Rays per batch call, a multiple of 64 [{}]", o.batch_size),
              [&o](auto text) { return set_batch_size(text, o.batch_size); });
  flags.value("--repeat", "N",
              fmt::format("Timed repetitions, after one that warms up and checks the answers [{}]", o.repeat),
              [&o](auto text) { return store(parse_integer(text, 1, 1000), o.repeat); });
  flags.value("--build-repeat", "N", fmt::format("Repetitions of each build [{}]", o.build_repeat),
              [&o](auto text) { return store(parse_integer(text, 1, 1000), o.build_repeat); });
  flags.value("--clock", "wall|cpu",
              fmt::format("Measure wall time, or CPU time of the tracing thread [{}]", clock_name(o.clock)),
              [&o](auto text) {
                return choose(clock_from_name(text), o.clock, "clock", text, {"wall", "cpu"});
              });
  flags.toggle("--no-embree-calls",
               "Race Embree only by the calls that rendering uses, without its packets and streams", o.embree_calls,
               false);
  flags.value("--rays", "FILE",
              "Replay the rays in this file, .kray or .npz (arrays origins, directions); if a .kray file does not "
              "exist, record rays and save them there [record rays]",
              [&o](auto text) { return set_rays_file(text, o.rays_file); });
  flags.value("--record-rays", "FILE", "Save the rays of the race to this .kray file, replacing it [none]",
              [&o](auto text) { return set_rays_file(text, o.record_rays_file); });
  flags.toggle("--compare",
               "Compare two reports of --json in place of a race: kindling shootout --compare a.json b.json",
               o.compare);
  flags.value(
      "--threads", "N",
      fmt::format("Threads for loading and for parallel builds; 0: all cores. Rays are traced on one [{}]", o.threads),
      [&o](auto text) { return store(parse_integer(text, 0, 1024), o.threads); });
  add_scene_flags(flags, o.view);
  flags.group("Image that rays are recorded from");
  add_size_flag(flags, o.view);
  flags.group("Reports");
  flags.value("--json", "FILE", "Write all measurements as JSON [none]",
              [&o](auto text) { return set_path(text, o.json_file); });
  flags.value("--csv", "FILE", "Write one line for each scene, accelerator, kind of rays and call [none]",
              [&o](auto text) { return set_path(text, o.csv_file); });
  flags.value("--html", "FILE", "Write a self-contained page with tables, plots and heat maps [none]",
              [&o](auto text) { return set_path(text, o.html_file); });
  flags.value("--heat-map", "PIXELS",
              fmt::format("Longer side of the page's heat maps; 0: none [{}]", o.heat_map_width_px),
              [&o](auto text) { return store(parse_integer(text, 0, 4096), o.heat_map_width_px); });
  flags.toggle("-q,--quiet", "Print the tables and errors only", o.view.quiet);
  flags.toggle("-v,--verbose", "Print details too", o.view.verbose);
}

Result<void> check_shootout_flags(const FlagSet& flags, ShootoutOptions& o) {
  if (o.compare) {
    if (o.scene_files.size() != 2)
      return usage_error(fmt::format("--compare: takes two reports of --json, {} are given", o.scene_files.size()));
    if (const auto words = flags.given_words({"--compare"}); !words.empty())
      return usage_error(fmt::format("{}: has no meaning with --compare", words.front()));
    return {};
  }
  if (o.scene_files.empty())
    return usage_error("no scene; use 'kindling shootout SCENE... [flags]' with .gltf or .glb files");
  if (!o.rays_file.empty() && o.scene_files.size() > 1)
    return usage_error(fmt::format("--rays: a file holds the rays of one scene; {} are given", o.scene_files.size()));
  if (!o.record_rays_file.empty() && o.scene_files.size() > 1)
    return usage_error(
        fmt::format("--record-rays: a file holds the rays of one scene; {} are given", o.scene_files.size()));
  if (o.record_rays_file.extension() == ".npz")
    return usage_error(
        fmt::format("--record-rays: '{}': rays are recorded to .kray files", o.record_rays_file.string()));
  if (flags.given("--plugin-time-limit") && o.plugins.empty())
    return usage_error("--plugin-time-limit: has no meaning without --plugin");
  if (o.device && o.clock == ShootoutClock::cpu)
    return usage_error("--clock cpu: a device is measured in wall time; leave out --clock or --device");
  if (flags.given("--heat-map") && o.html_file.empty()) return usage_error("--heat-map: has no meaning without --html");
  if (o.view.quiet && o.view.verbose) return usage_error("--quiet and --verbose: give one of them");
  const std::array files{&o.json_file, &o.csv_file, &o.html_file, &o.rays_file, &o.record_rays_file};
  for (size_t i = 0; i < files.size(); ++i)
    for (size_t j = 0; j < i; ++j)
      if (!files[i]->empty() && files[i]->lexically_normal() == files[j]->lexically_normal())
        return usage_error(fmt::format("{}: two reports cannot have the same name", files[i]->string()));
  if (o.isa) limit_instruction_set(o.accelerators, *o.isa);
  return check_scene_flags(flags, o.view);
}

} // namespace kindling::app
