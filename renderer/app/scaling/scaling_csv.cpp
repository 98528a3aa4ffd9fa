// Writes scaling as comma-separated values (RFC 4180); renders and phases share a table.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/scaling/scaling_report.h"
#include "renderer/app/text/text_format.h"

#include <fmt/format.h>

namespace kindling::app {

namespace {

std::string number_or_nothing(const std::optional<uint64_t>& value) {
  return value ? fmt::format("{}", *value) : std::string();
}

} // namespace

std::string format_scaling_csv(const ScalingReport& report) {
  std::string text =
      "scene,phase,accelerator,schedule,threads,rounds,median_s,min_s,max_s,cpu_s,speedup,efficiency,rays_per_s,"
      "paths_per_s,idle_share,waiting_share,peak_rss_bytes,accelerator_bytes,film_bytes,image\n";
  for (const SceneScaling& scene : report.scenes) {
    for (const AcceleratorScaling& a : scene.accelerators)
      for (const RenderRow& row : a.renders) {
        if (row.samples.empty()) continue;
        const RenderScaling r = summarize_render(a, row);
        text += fmt::format("{},render,{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", csv_field(scene.file),
                            a.variant.name(), schedule_name(row.schedule), row.threads, row.samples.size(),
                            r.wall_s.median, r.wall_s.min, r.wall_s.max, r.cpu_s, r.speedup.median, r.efficiency,
                            r.rays_per_s, r.paths_per_s, r.idle_share, r.waiting_share, number_or_nothing(r.peak_bytes),
                            a.accelerator_bytes, scene.film_bytes, format_hash(row.samples.front().hash));
      }
    for (const PhaseScaling& phase : summarize_phases(scene))
      for (const PhaseScaling::Point& p : phase.points)
        text += fmt::format("{},{},,,{},,{},{},{},{},{},{},,,,,,,,\n", csv_field(scene.file), csv_field(phase.name),
                            p.threads, p.wall_s.median, p.wall_s.min, p.wall_s.max, p.parallelism * p.wall_s.median,
                            p.speedup, p.speedup / p.threads);
  }
  return text;
}

} // namespace kindling::app
