// Writes the report of a render as JSON; README.md describes the keys.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/output/report.h"
#include "renderer/app/terminal/version.h"
#include "renderer/app/text/text_format.h"

#include <nlohmann/json.hpp>

namespace kindling::app {
namespace {

nlohmann::ordered_json device_json(const DeviceUse& device) {
  nlohmann::ordered_json json = {{"name", device.name},
                                 {"scene_bytes", device.scene_bytes},
                                 {"peak_bytes", device.peak_bytes},
                                 {"wave_paths", device.wave_paths},
                                 {"start_s", device.start_s},
                                 {"tiles", nullptr}};
  if (const TileStatistics& tiles = device.tiles; tiles.tiles > 0)
    json["tiles"] = {{"tiles", tiles.tiles},   {"slots", tiles.slots},     {"min_slots", tiles.min_slots},
                     {"loaded", tiles.loaded}, {"evicted", tiles.evicted}, {"stages_again", tiles.stages_again}};
  json["kernels"] = nlohmann::ordered_json::object();
  for (const Kernel kernel : kAllKernels)
    if (const KernelUse& use = device.kernels[static_cast<size_t>(kernel)]; use.launches > 0)
      json["kernels"][kernel_name(kernel)] = {
          {"launches", use.launches}, {"threads", use.threads}, {"seconds", use.seconds}};
  if (!device.why_cpu.empty()) json["why_cpu"] = device.why_cpu;
  return json;
}

nlohmann::ordered_json light_paths_json(const LightPathChoice& l) {
  return {{"fraction", l.fraction},
          {"predicted", l.predicted},
          {"pilot_camera_paths", l.camera_paths},
          {"pilot_light_paths", l.light_paths},
          {"pilot_rays", l.rays.total()}};
}

nlohmann::ordered_json photons_json(const PhotonChoice& p) {
  return {
      {"fraction", p.fraction}, {"predicted", p.predicted}, {"pilot_paths", p.paths}, {"pilot_rays", p.rays.total()}};
}

nlohmann::ordered_json choice_json(std::string_view of, const SampleChoice& c) {
  return {{of, c.count}, {"predicted", c.predicted}, {"pilot_paths", c.paths}, {"pilot_rays", c.rays.total()}};
}

nlohmann::ordered_json sample_rates_json(const RateChoice& c) {
  return {{"kind", sample_rates_name(c.rule.kind())},
          {"predicted", c.predicted},
          {"pilot_paths", c.paths},
          {"pilot_rays", c.rays.total()}};
}

nlohmann::ordered_json rays_json(const RayCounters& rays) {
  return {{"camera", rays.camera},
          {"bounce", rays.bounce},
          {"shadow", rays.shadow},
          {"total", rays.total()},
          {"photon", rays.photon}};
}

nlohmann::ordered_json guiding_json(const GuidingStatistics& g, Guiding mode) {
  return {{"mode", guiding_name(mode)},
          {"patches", g.patches},
          {"environment_regions", g.environment_regions},
          {"predicted_environment", g.predicted_environment},
          {"light_regions", g.light_regions},
          {"predicted", g.predicted},
          {"predicted_lights", g.predicted_lights},
          {"volume_regions", g.volume_regions},
          {"caustic_regions", g.caustic_regions},
          {"caustic_share", g.caustic_share},
          {"training_paths", g.paths},
          {"training_rays", g.rays.total()}};
}

} // namespace

std::string format_stats_json(const RenderReport& r, bool one_line) {
  const RenderStatistics& s = r.statistics;
  const accel::Statistics& a = r.world.accelerator;
  nlohmann::ordered_json json;
  if (one_line) json["event"] = "summary";
  json["version"] = version();
  json["compiler"] = compiler();
  json["command_line"] = r.command_line;
  json["scene"] = r.scene_file;
  json["scene_hash"] = format_hash(r.scene_hash);
  json["frame"] = r.frame ? nlohmann::ordered_json(*r.frame) : nlohmann::ordered_json();
  json["time_s"] = r.time_s ? nlohmann::ordered_json(*r.time_s) : nlohmann::ordered_json();
  json["width"] = r.size_px.x;
  json["height"] = r.size_px.y;
  json["crop"] = {r.crop.min.x, r.crop.min.y, r.crop.max.x, r.crop.max.y};
  json["spp"] = s.samples_per_pixel;
  json["spp_wanted"] = r.spp_wanted;
  json["spp_mean"] = r.mean_spp;
  json["adaptive"] = nullptr;
  if (r.adaptive.enabled())
    json["adaptive"] = {{"noise_threshold", r.adaptive.noise_threshold},
                        {"min_spp", r.adaptive.min_samples_per_pixel},
                        {"converged", s.converged_share}};
  json["seed"] = r.seed;
  json["threads"] = s.threads;
  json["device"] = device_json(s.device);
  json["integrator"] = r.integrator;
  json["view"] = r.view;
  json["interrupted"] = r.interrupted;
  json["warnings"] = r.warnings;
  json["phases"] = {{"load", r.times.load_s},
                    {"files", r.times.import.files.wall_s},
                    {"meshes", r.times.import.meshes.wall_s},
                    {"tangents", r.times.import.tangents.wall_s},
                    {"textures", r.times.import.textures.wall_s},
                    {"environment", r.times.environment.image.wall_s},
                    {"distribution", r.times.environment.distribution.wall_s},
                    {"build", r.times.build_s},
                    {"levels", r.world.times.textures.wall_s},
                    {"geometry", r.world.times.geometry.wall_s},
                    {"lights", r.world.times.lights.wall_s},
                    {"accelerator", r.world.times.accelerator.wall_s},
                    {"pilot", s.light_paths.pilot_s + s.path_reuse.pilot_s + s.direct_samples.pilot_s +
                                  s.photons.pilot_s + s.sample_rates.pilot_s},
                    {"training", s.guiding.training_s},
                    {"render", r.times.render_s},
                    {"denoise", r.times.denoise_s},
                    {"write", r.times.write_s}};
  json["total_s"] = r.times.total_s;
  json["time_to_first_ray_s"] = r.times.before_render_s;
  json["time_to_first_pixel_s"] = r.time_to_first_pixel_s();
  json["passes"] = s.passes;
  json["guiding"] = guiding_json(s.guiding, r.guiding);
  json["light_paths"] = light_paths_json(s.light_paths);
  json["direct_samples"] = choice_json("samples", s.direct_samples);
  json["direct_samples"]["reflection_samples"] = s.direct_samples.reflections;
  json["path_reuse"] = choice_json("pixels", s.path_reuse);
  json["photons"] = photons_json(s.photons);
  json["sample_rates"] = sample_rates_json(s.sample_rates);
  json["schedule"] = schedule_name(r.schedule);
  json["idle_s"] = s.idle_s;
  json["worker_idle_s"] = s.worker_idle_s;
  json["rays"] = rays_json(s.rays);
  if (r.whitted) {
    const WhittedCounters& w = s.rays.whitted;
    json["whitted"] = {{"form", whitted_form_name(r.whitted->form)},
                       {"trace_depth", r.whitted->trace_depth},
                       {"max_reflections", std::min(r.whitted->max_reflections, r.whitted->trace_depth)},
                       {"reflection_rays", w.reflection},
                       {"transmission_rays", w.transmission},
                       {"cache",
                        {{"enabled", r.whitted->cache},
                         {"hits", w.cache_hits},
                         {"misses", w.cache_misses},
                         {"bypasses", w.cache_bypasses}}}};
  }
  json["rays_per_s"] = r.rays_per_s();
  json["paths"] = s.rays.paths;
  json["paths_per_s"] = r.paths_per_s();
  json["non_finite_samples"] = s.rays.non_finite;
  json["accelerator"] = {{"name", r.accelerator},         {"description", r.accelerator_description},
                         {"build_s", a.build_s},          {"memory_bytes", a.memory_bytes},
                         {"triangles", a.triangle_count}, {"built_triangles", a.built_triangle_count},
                         {"instances", a.instance_count}, {"nodes", a.node_count},
                         {"leaves", a.leaf_count},        {"references", a.reference_count}};
  json["checkpoint"] = nullptr;
  if (const auto& c = r.checkpoint)
    json["checkpoint"] = {{"file", c->file},
                          {"saves", c->saves},
                          {"failed_saves", c->failed_saves},
                          {"save_s", c->save_s},
                          {"spp_before", c->spp_before},
                          {"runs", c->work.runs},
                          {"render_s", c->work.render_s},
                          {"thread_s", c->work.thread_s},
                          {"rays", c->work.rays.total()}};
  json["shutter"] = nullptr;
  if (r.shutter) {
    const MotionStatistics& m = r.world.motion;
    json["shutter"] = {{"open_s", r.shutter->open_s},
                       {"close_s", r.shutter->close_s},
                       {"moving_instances", m.moving_instance_count},
                       {"deforming_meshes", m.deforming_mesh_count},
                       {"max_keys", m.max_keys},
                       {"key_bytes", m.key_bytes}};
  }
  json["emissive_triangles"] = r.world.emissive_triangle_count;
  json["memory"] = {{"geometry_bytes", r.world.geometry_bytes},
                    {"accelerator_bytes", a.memory_bytes},
                    {"texture_bytes", r.world.texture_bytes},
                    {"light_bytes", r.world.light_bytes},
                    {"film_bytes", r.film_bytes}};
  json["peak_rss_bytes"] = r.peak_resident_bytes;
  json["outputs"] = r.outputs;
  return json.dump(one_line ? -1 : 2, ' ', false, nlohmann::json::error_handler_t::replace);
}

} // namespace kindling::app
