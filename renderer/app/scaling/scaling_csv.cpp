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

// A device alone and with the processor; columns that have no meaning for it are empty.
std::string device_lines(const ScalingReport& report, const SceneScaling& scene) {
  const DeviceScaling& device = *scene.device;
  const DeviceSummary s = summarize_device(report, scene);
  std::string text;
  const auto add = [&](bool shared, int threads, size_t rounds, const Summary& wall_s, double samples_per_s,
                       uint64_t hash) {
    const double one_s = s.processors.empty() ? 0.0 : s.processors.front().median_s;
    text += fmt::format("{},render,{},,{},{},{},{},{},,{},,,{},,,,,{},{}\n", csv_field(scene.file),
                        csv_field(device_renderer(device, shared)), threads, rounds, wall_s.median, wall_s.min,
                        wall_s.max, wall_s.median > 0.0 ? one_s / wall_s.median : 0.0, samples_per_s, scene.film_bytes,
                        format_hash(hash));
  };
  if (!device.alone.empty()) add(false, 0, device.alone.size(), s.alone_s, s.samples_per_s, device.alone.front().hash);
  if (!device.shared.empty())
    add(true, device.shared.back().threads, device.shared.size(), s.shared_s, s.shared_samples_per_s,
        device.shared.front().hash);
  return text;
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
    if (scene.device) text += device_lines(report, scene);
    for (const PhaseScaling& phase : summarize_phases(scene))
      for (const PhaseScaling::Point& p : phase.points)
        text += fmt::format("{},{},,,{},,{},{},{},{},{},{},,,,,,,,\n", csv_field(scene.file), csv_field(phase.name),
                            p.threads, p.wall_s.median, p.wall_s.min, p.wall_s.max, p.parallelism * p.wall_s.median,
                            p.speedup, p.speedup / p.threads);
  }
  return text;
}

} // namespace kindling::app
