// Writes scaling as JSON; README.md describes the keys.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/measure/machine_load.h"
#include "renderer/app/measure/measurement_json.h"
#include "renderer/app/scaling/scaling_report.h"
#include "renderer/app/terminal/version.h"
#include "renderer/app/text/text_format.h"

namespace kindling::app {

namespace {

using Json = nlohmann::ordered_json;

Json number_or_null(const std::optional<uint64_t>& value) { return value ? Json(*value) : Json(); }

Json fit_json(const std::optional<AmdahlFit>& fit) {
  if (!fit) return {};
  return {{"serial_share", fit->serial_share}, {"residual", fit->residual}, {"counts", fit->counts}};
}

Json render_json(const AcceleratorScaling& accelerator, const RenderRow& row) {
  const RenderScaling r = summarize_render(accelerator, row);
  std::vector<double> wall_s;
  Json json = {{"schedule", schedule_name(row.schedule)}, {"threads", row.threads}};
  for (const RenderSample& sample : row.samples) wall_s.push_back(sample.time.wall_s);
  json.update(summary_json(wall_s));
  json["cpu_s"] = r.cpu_s;
  json["training_s"] = r.training_s;
  json["speedup"] = r.speedup.median;
  json["speedup_min"] = r.speedup.min;
  json["speedup_max"] = r.speedup.max;
  json["efficiency"] = r.efficiency;
  json["rays_per_s"] = r.rays_per_s;
  json["paths_per_s"] = r.paths_per_s;
  json["idle_share"] = r.idle_share;
  json["waiting_share"] = r.waiting_share;
  json["cpu_growth"] = r.cpu_growth;
  json["peak_rss_bytes"] = number_or_null(r.peak_bytes);
  json["render_growth_bytes"] = number_or_null(r.growth_bytes);
  json["images"] = Json::array();
  for (const RenderSample& sample : row.samples) json["images"].push_back(format_hash(sample.hash));
  return json;
}

Json scaling_accelerator_json(const ScalingReport& report, const AcceleratorScaling& accelerator) {
  Json json = {{"name", accelerator.variant.name()},
               {"description", accel::kind_description(accelerator.variant.kind)},
               {"memory_bytes", accelerator.accelerator_bytes}};
  json["render"] = Json::array();
  for (const RenderRow& row : accelerator.renders)
    if (!row.samples.empty()) json["render"].push_back(render_json(accelerator, row));
  json["amdahl"] = Json::object();
  for (const Schedule schedule : report.schedules)
    json["amdahl"][std::string(schedule_name(schedule))] = fit_json(fit_renders(accelerator, schedule, report.cores));
  return json;
}

Json phases_json(const SceneScaling& scene) {
  Json json = Json::array();
  for (const PhaseScaling& phase : summarize_phases(scene)) {
    Json points = Json::array();
    for (const PhaseScaling::Point& point : phase.points)
      points.push_back({{"threads", point.threads},
                        {"median_s", point.wall_s.median},
                        {"min_s", point.wall_s.min},
                        {"max_s", point.wall_s.max},
                        {"speedup", point.speedup},
                        {"cores_used", point.parallelism}});
    json.push_back({{"phase", phase.name}, {"threads", std::move(points)}});
  }
  return json;
}

// The summary of the times, and the hashes of the images.
template <typename Samples, typename Time>
Json device_times_json(const Samples& samples, const Time& time) {
  std::vector<double> times_s;
  Json images = Json::array();
  for (const auto& sample : samples) {
    times_s.push_back(time(sample));
    images.push_back(format_hash(sample.hash));
  }
  Json json = summary_json(times_s);
  json["images"] = std::move(images);
  return json;
}

Json scaling_device_json(const ScalingReport& report, const SceneScaling& scene) {
  const DeviceScaling& device = *scene.device;
  const DeviceSummary s = summarize_device(report, scene);
  Json json = {{"kind", device_kind_name(device.kind)},
               {"name", device.name},
               {"accelerator", scene.accelerators[device.accelerator].variant.name()},
               {"scene_bytes", device.alone.empty() ? 0 : device.alone.back().scene_bytes}};
  json["alone"] = device_times_json(device.alone, [](const DeviceSample& sample) { return sample.time.wall_s; });
  json["alone"].update({{"start_s", s.start_s}, {"samples_per_s", s.samples_per_s}, {"rays_per_s", s.rays_per_s}});
  json["alone"]["processors"] = Json::array();
  for (const DeviceSummary::Processor& p : s.processors)
    json["alone"]["processors"].push_back(
        {{"threads", p.threads}, {"samples_per_s", p.samples_per_s}, {"ratio", p.ratio}});
  json["shared"] = device_times_json(device.shared, [](const SharedSample& sample) { return sample.wall_s; });
  json["shared"].update({{"threads", device.shared.empty() ? 0 : device.shared.back().threads},
                         {"processor_share", s.processor_share},
                         {"processor_s", s.processor_s},
                         {"device_s", s.device_s},
                         {"merge_s", s.merge_s},
                         {"samples_per_s", s.shared_samples_per_s},
                         {"speedup", s.shared_speedup}});
  return json;
}

Json scaling_scene_json(const ScalingReport& report, const SceneScaling& scene) {
  Json json;
  json["file"] = scene.file;
  json["width"] = scene.size_px.x;
  json["height"] = scene.size_px.y;
  json["spp"] = scene.samples_per_pixel;
  json["triangles"] = scene.triangle_count;
  json["instances"] = scene.instance_count;
  json["memory"] = {{"geometry_bytes", scene.geometry_bytes},
                    {"texture_bytes", scene.texture_bytes},
                    {"light_bytes", scene.light_bytes},
                    {"film_bytes", scene.film_bytes}};
  const double waiting = worst_waiting_share(report, scene);
  json["waiting_share"] = waiting;
  json["warning"] = waiting < kQuietWaitingShare ? Json() : Json(disturbance_warning(waiting));
  json["accelerators"] = Json::array();
  for (const AcceleratorScaling& accelerator : scene.accelerators)
    json["accelerators"].push_back(scaling_accelerator_json(report, accelerator));
  json["device"] = scene.device ? scaling_device_json(report, scene) : Json();
  json["preparation"] = phases_json(scene);
  json["mismatches"] = Json::array();
  for (const ImageMismatch& m : find_mismatches(scene))
    json["mismatches"].push_back({{"accelerator", m.renderer},
                                  {"schedule", m.schedule ? Json(schedule_name(*m.schedule)) : Json()},
                                  {"threads", m.threads},
                                  {"round", m.round}});
  return json;
}

} // namespace

std::string format_scaling_json(const ScalingReport& report) {
  Json json;
  json["version"] = version();
  json["compiler"] = compiler();
  json["command_line"] = report.command_line;
  json["processor"] = report.processor;
  json["cores"] = report.cores;
  json["integrator"] = report.integrator;
  json["thread_counts"] = report.thread_counts;
  json["repeat"] = report.repeat;
  json["interrupted"] = report.interrupted;
  json["scenes"] = Json::array();
  for (const SceneScaling& scene : report.scenes) json["scenes"].push_back(scaling_scene_json(report, scene));
  json["summary"] = Json::array();
  for (const EfficiencySummary& s : summarize_scenes(report))
    json["summary"].push_back({{"accelerator", s.accelerator},
                               {"schedule", schedule_name(s.schedule)},
                               {"threads", s.threads},
                               {"efficiency_geometric_mean", s.mean},
                               {"efficiency_worst", s.worst},
                               {"worst_scene", s.worst_scene},
                               {"idle_share_mean", s.mean_idle_share}});
  json["paper"] = Json::array();
  for (const PaperSpeedup& paper : paper_speedups())
    json["paper"].push_back({{"threads", paper.threads},
                             {"speedup_low", paper.low},
                             {"speedup_high", paper.high},
                             {"processor", paper.processor}});
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

} // namespace kindling::app
