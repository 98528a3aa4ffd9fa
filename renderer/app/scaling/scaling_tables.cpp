// Formats scaling as tables for a terminal.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/measure/machine_load.h"
#include "renderer/app/scaling/scaling_report.h"
#include "renderer/app/text/text_format.h"

#include <fmt/format.h>

#include <algorithm>

namespace kindling::app {

namespace {

constexpr double kShownPhase_s = 0.0005; // phases that never take as long are only in the JSON

std::string percent(double share) { return fmt::format("{:.1f} %", share * 100.0); }

std::string bytes_or_unknown(const std::optional<uint64_t>& bytes) { return bytes ? format_bytes(*bytes) : "unknown"; }

std::string render_table(const ScalingReport& report, const SceneScaling& scene) {
  TextTable table({{"accelerator"},
                   {"schedule"},
                   {"threads", true},
                   {"time", true},
                   {"spread", true},
                   {"speed-up", true},
                   {"efficiency", true},
                   {"CPU time", true},
                   {"rays/s", true},
                   {"paths/s", true},
                   {"idle", true},
                   {"waiting", true},
                   {"peak memory", true},
                   {"by render", true}});
  for (const AcceleratorScaling& accelerator : scene.accelerators)
    for (const RenderRow& row : accelerator.renders) {
      if (row.samples.empty()) continue;
      const RenderScaling r = summarize_render(accelerator, row);
      table.add({accelerator.variant.name(), std::string(schedule_name(row.schedule)),
                 fmt::format("{}{}", row.threads, row.threads > report.cores ? "*" : ""),
                 format_seconds(r.wall_s.median), fmt::format("{:.1f} %", r.wall_s.spread_percent()),
                 r.speedup.median > 0.0 ? fmt::format("{:.3f}", r.speedup.median) : "-",
                 r.efficiency > 0.0 ? fmt::format("{:.3f}", r.efficiency) : "-", format_seconds(r.cpu_s),
                 format_count(r.rays_per_s), format_count(r.paths_per_s), percent(r.idle_share),
                 percent(r.waiting_share), bytes_or_unknown(r.peak_bytes), bytes_or_unknown(r.growth_bytes)});
    }
  return table.str();
}

std::string disturbance_line(const ScalingReport& report, const SceneScaling& scene) {
  const std::string warning = disturbance_warning(worst_waiting_share(report, scene));
  return warning.empty() ? warning : "  " + warning + "\n";
}

std::string fit_lines(const ScalingReport& report, const SceneScaling& scene) {
  std::string text;
  for (const AcceleratorScaling& accelerator : scene.accelerators)
    for (const Schedule schedule : report.schedules) {
      const std::optional<AmdahlFit> fit = fit_renders(accelerator, schedule, report.cores);
      if (!fit) continue;
      text += fmt::format("  {}, {}: serial {}", accelerator.variant.name(), schedule_name(schedule),
                          percent(fit->serial_share));
      text += fit->counts > 1 ? fmt::format(", residual {}\n", percent(fit->residual)) : "\n";
    }
  if (text.empty()) return {};
  const bool one_count = std::count_if(report.thread_counts.begin(), report.thread_counts.end(),
                                       [&](int n) { return n > 1 && n <= report.cores; }) < 2;
  return "\nAmdahl's law, T(n) = T(1) (s + (1 - s) / n)\n" + text +
         (one_count ? "  A single count besides 1 fits any s: it does not predict the speed-up of more threads.\n"
                    : "");
}

std::string paper_lines(const SceneScaling& scene) {
  std::string text;
  for (const PaperSpeedup& paper : paper_speedups())
    for (const AcceleratorScaling& accelerator : scene.accelerators) {
      const RenderRow* regions = find_row(accelerator, Schedule::regions, paper.threads);
      const RenderRow* tiles = find_row(accelerator, Schedule::tiles, paper.threads);
      if (regions == nullptr || regions->samples.empty()) continue;
      const RenderScaling r = summarize_render(accelerator, *regions);
      text += fmt::format("  {} threads, {}: regions {:.2f} (idle {})", paper.threads, accelerator.variant.name(),
                          r.speedup.median, percent(r.idle_share));
      if (tiles != nullptr && !tiles->samples.empty()) {
        const RenderScaling t = summarize_render(accelerator, *tiles);
        text += fmt::format(", tiles {:.2f} (idle {})", t.speedup.median, percent(t.idle_share));
      }
      const std::string range =
          paper.high > paper.low ? fmt::format("{:g} to {:g}", paper.low, paper.high) : fmt::format("{:g}", paper.low);
      text += fmt::format("; the paper's regions {} ({})\n", range, paper.processor);
    }
  return text.empty() ? text : "\nspeed-up of static regions, as in the paper, and of tiles\n" + text;
}

std::string preparation_table(const ScalingReport& report, const SceneScaling& scene) {
  std::vector<TextTable::Column> columns{{"phase"}};
  for (const int threads : report.thread_counts)
    columns.push_back({fmt::format("{} thread{}", threads, threads == 1 ? "" : "s"), true});
  const bool several = report.thread_counts.size() > 1;
  if (several) {
    columns.push_back({"speed-up", true});
    columns.push_back({"cores used", true});
  }
  TextTable table(columns);
  for (const PhaseScaling& phase : summarize_phases(scene)) {
    double slowest = 0.0;
    for (const PhaseScaling::Point& point : phase.points) slowest = std::max(slowest, point.wall_s.median);
    if (slowest < kShownPhase_s) continue;
    std::vector<std::string> cells{phase.name};
    for (const PhaseScaling::Point& point : phase.points) cells.push_back(format_short_time(point.wall_s.median));
    if (several) {
      cells.push_back(fmt::format("{:.2f}", phase.points.back().speedup));
      cells.push_back(fmt::format("{:.2f}", phase.points.back().parallelism));
    }
    table.add(cells);
  }
  return table.empty() ? std::string() : "\nbefore the first path, medians\n" + table.str();
}

std::string mismatch_lines(const SceneScaling& scene) {
  std::string text;
  for (const ImageMismatch& m : find_mismatches(scene)) {
    text += "  " + m.renderer;
    if (m.schedule) text += fmt::format(", {}", schedule_name(*m.schedule));
    if (m.threads > 0) text += fmt::format(", {} thread{}", m.threads, m.threads == 1 ? "" : "s");
    text += fmt::format(", round {}: DIFFERENT IMAGE\n", m.round + 1);
  }
  if (!text.empty()) return text;
  size_t images = 0;
  for (const AcceleratorScaling& accelerator : scene.accelerators)
    for (const RenderRow& row : accelerator.renders) images += row.samples.size();
  text = fmt::format("  {} images, bit-identical for each accelerator\n", images);
  if (scene.device)
    text += fmt::format("  {} images of {} and {} merged ones, bit-identical to those of {}\n",
                        scene.device->alone.size(), device_renderer(*scene.device, false), scene.device->shared.size(),
                        scene.accelerators[scene.device->accelerator].variant.name());
  return text;
}

} // namespace

std::string format_scaling_tables(const ScalingReport& report, const SceneScaling& scene) {
  size_t rounds = 0;
  for (const AcceleratorScaling& accelerator : scene.accelerators)
    for (const RenderRow& row : accelerator.renders) rounds = std::max(rounds, row.samples.size());
  std::string text = fmt::format(
      "{}\n  {} triangles, {} instances; {} x {} pixels, {} sample{} per pixel, {}; {} core{}{}{}; medians of {}\n\n",
      scene_name(scene), scene.triangle_count, scene.instance_count, scene.size_px.x, scene.size_px.y,
      scene.samples_per_pixel, scene.samples_per_pixel == 1 ? "" : "s", report.integrator, report.cores,
      report.cores == 1 ? "" : "s", report.processor.empty() ? "" : " of ", report.processor, rounds);
  text += render_table(report, scene);
  if (!report.thread_counts.empty() && report.thread_counts.back() > report.cores)
    text += "  * more threads than cores\n";
  text += mismatch_lines(scene) + disturbance_line(report, scene);
  text += format_device_scaling(report, scene);
  text += fit_lines(report, scene) + paper_lines(scene) + preparation_table(report, scene);
  std::string accelerators;
  for (const AcceleratorScaling& accelerator : scene.accelerators)
    accelerators += fmt::format(", {} {}", accelerator.variant.name(), format_bytes(accelerator.accelerator_bytes));
  text += fmt::format("\nmemory: geometry {}, textures {}, lights {}, film {}{}\n", format_bytes(scene.geometry_bytes),
                      format_bytes(scene.texture_bytes), format_bytes(scene.light_bytes),
                      format_bytes(scene.film_bytes), accelerators);
  return text;
}

std::string format_scaling_summary(const ScalingReport& report) {
  TextTable table({{"accelerator"},
                   {"schedule"},
                   {"threads", true},
                   {"efficiency", true},
                   {"worst", true},
                   {"of", false, true},
                   {"idle", true}});
  for (const EfficiencySummary& s : summarize_scenes(report))
    table.add({s.accelerator, std::string(schedule_name(s.schedule)),
               fmt::format("{}{}", s.threads, s.threads > report.cores ? "*" : ""), fmt::format("{:.3f}", s.mean),
               fmt::format("{:.3f}", s.worst), s.worst_scene, percent(s.mean_idle_share)});
  if (table.empty()) return {};
  return fmt::format("\n{} scenes: geometric mean of the efficiencies, the worst one, mean idle time\n{}",
                     report.scenes.size(), table.str());
}

} // namespace kindling::app
