// The flags of `kindling shootout`: name, unit, default, and where each value goes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/command_flags.h"
#include "renderer/app/flags/flag_set.h"
#include "renderer/app/flags/scene_flags.h"
#include "renderer/app/options/options.h"
#include "renderer/app/text/parse_values.h"

#include <fmt/format.h>

#include <array>

namespace kindling::app {

namespace {

std::optional<ShootoutClock> clock_from_name(std::string_view name) {
  if (name == "wall") return ShootoutClock::wall;
  if (name == "cpu") return ShootoutClock::cpu;
  return std::nullopt;
}

} // namespace

void add_shootout_flags(FlagSet& flags, ShootoutOptions& o) {
  flags.group("Race");
  flags.value("--accel", "SPEC[,SPEC]...",
              "Accelerators, NAME[:QUALITY][:robust|:non-robust][:SIMD]: embree, kdtree or brute-force; fast, balanced "
              "or best; for kdtree portable, avx2 or avx512, for embree sse2, sse4.2, avx, avx2 or avx512 [the "
              "processor's best]; the first is what others are compared with "
              "[embree,embree:non-robust,embree:best:non-robust,kdtree]",
              [&o](auto text) { return store(parse_accelerator_variants(text), o.accelerators); });
  flags.value("--isa", "SIMD",
              "Race as on a processor with no more than this instruction set: sse2, sse4.2, avx, avx2 or avx512 [the "
              "processor's best]",
              [&o](auto text) -> Result<void> {
                const Result<accel::SimdTarget> isa = parse_instruction_set(text);
                if (!isa.ok()) return isa.error();
                o.isa = isa.value();
                return {};
              });
  flags.value("--rays-per-kind", "N", "Rays of each kind [131072]",
              [&o](auto text) { return store(parse_integer(text, 1, 1 << 26), o.rays_per_kind); });
  flags.value("--batch-size", "N", "Rays of a batch call, a multiple of 64 [256, as the path tracer has]",
              [&o](auto text) { return set_batch_size(text, o.batch_size); });
  flags.value("--repeat", "N", "Repetitions, after one that warms up and checks [5]",
              [&o](auto text) { return store(parse_integer(text, 1, 1000), o.repeat); });
  flags.value("--build-repeat", "N", "Repetitions of each build [3]",
              [&o](auto text) { return store(parse_integer(text, 1, 1000), o.build_repeat); });
  flags.value("--clock", "wall|cpu", "Time that passes, or CPU time of the one thread [wall]", [&o](auto text) {
    return choose(clock_from_name(text), o.clock, "clock", text, {"wall", "cpu"});
  });
  flags.toggle("--no-embree-calls",
               "Race Embree by the calls that rendering uses only, not by all of its packets and streams",
               o.embree_calls, false);
  flags.value("--rays", "FILE",
              "Replay the rays in this file; if there is none, record them and save them there [record]",
              [&o](auto text) { return set_path(text, o.rays_file); });
  flags.value("--threads", "N", "For loading, and for builds on many threads; 0: all. Rays are traced on one [0]",
              [&o](auto text) { return store(parse_integer(text, 0, 1024), o.threads); });
  add_scene_flags(flags, o.view);
  flags.group("Image that the rays are recorded for");
  add_size_flag(flags, o.view);
  flags.group("Reports");
  flags.value("--json", "FILE", "Everything that was measured [none]",
              [&o](auto text) { return set_path(text, o.json_file); });
  flags.value("--csv", "FILE", "One line for each scene, accelerator, kind of rays and call [none]",
              [&o](auto text) { return set_path(text, o.csv_file); });
  flags.value("--html", "FILE", "One page with tables, plots and heat maps, complete in itself [none]",
              [&o](auto text) { return set_path(text, o.html_file); });
  flags.value("--heat-map", "PIXELS", "Longer side of the page's heat maps; 0: none [320]",
              [&o](auto text) { return store(parse_integer(text, 0, 4096), o.heat_map_width_px); });
  flags.toggle("-q,--quiet", "Print the tables and errors only", o.view.quiet);
  flags.toggle("-v,--verbose", "Print details too", o.view.verbose);
}

Result<void> check_shootout_flags(const FlagSet& flags, ShootoutOptions& o) {
  if (o.scene_files.empty())
    return usage_error("no scene; use 'kindling shootout SCENE... [flags]' with .gltf or .glb files");
  if (!o.rays_file.empty() && o.scene_files.size() > 1)
    return usage_error(fmt::format("--rays: a file holds the rays of one scene; {} are given", o.scene_files.size()));
  if (flags.given("--heat-map") && o.html_file.empty()) return usage_error("--heat-map: has no meaning without --html");
  if (o.view.quiet && o.view.verbose) return usage_error("--quiet and --verbose: give one of them");
  const std::array files{&o.json_file, &o.csv_file, &o.html_file, &o.rays_file};
  for (size_t i = 0; i < files.size(); ++i)
    for (size_t j = 0; j < i; ++j)
      if (!files[i]->empty() && files[i]->lexically_normal() == files[j]->lexically_normal())
        return usage_error(fmt::format("{}: two reports cannot have one name", files[i]->string()));
  if (o.isa) limit_instruction_set(o.accelerators, *o.isa);
  return check_scene_flags(flags, o.view);
}

} // namespace kindling::app
