// Writes the settings that pixels depend on as JSON, by flag of the command line.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/pixel_settings.h"

#include "accel/simd_target.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <vector>

namespace kindling {

namespace {

using SortedJson = nlohmann::json; // keys in order

// Returns the shortest text that gives this number back; null for a limit that is infinite.
template <typename T>
SortedJson json_number(T value) {
  return std::isfinite(value) ? SortedJson::parse(fmt::format("{}", value)) : SortedJson();
}
template <typename T>
SortedJson json_number(const std::optional<T>& value) {
  return value ? json_number(*value) : SortedJson();
}
// The kd-tree's kernels agree to the bit on all processors. Embree chooses kernels by the
// processor, and uses reciprocal approximations that differ among makers of processors.
std::string accelerator_identity(accel::Kind kind) {
  std::string identity(accel::kind_description(kind)); // with the version of a library
  if (kind != accel::Kind::embree) return identity;
#ifdef __x86_64__
  const char* maker = __builtin_cpu_is("amd") ? "AMD" : __builtin_cpu_is("intel") ? "Intel" : "another maker";
#else
  const char* maker = "another maker";
#endif
  return fmt::format("{}, {} of {}", identity, accel::simd_target_name(accel::best_simd_target()), maker);
}

SortedJson json_vector(const V3f& v) { return {json_number(v.x), json_number(v.y), json_number(v.z)}; }
SortedJson json_vector(const std::optional<V3f>& v) { return v ? json_vector(*v) : SortedJson(); }
SortedJson color(const std::optional<Rgb>& c) {
  return c ? SortedJson{json_number(c->x), json_number(c->y), json_number(c->z)} : SortedJson();
}
SortedJson pixel(const std::optional<V2i>& p) { return p ? SortedJson{p->x, p->y} : SortedJson(); }

SortedJson matrix(const M44f& m) {
  SortedJson values = SortedJson::array();
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) values.push_back(json_number(m[row][column]));
  return values;
}

// A camera that a program placed itself. add_lens() overrides its lens by LensOptions.
SortedJson own_camera(const PlacedCamera& placed) {
  const SceneCamera& camera = placed.camera;
  const CameraLens& lens = camera.lens;
  SortedJson json;
  json["camera_to_world"] = matrix(placed.camera_to_world);
  json["later"] = SortedJson::array();
  for (const M44f& later : placed.later_transforms) json["later"].push_back(matrix(later));
  if (camera.kind == SceneCamera::Kind::orthographic)
    json["ymag"] = json_number(camera.ymag);
  else
    json["yfov"] = json_number(camera.yfov_rad);
  json["lens"] = {json_number(lens.f_stop),
                  json_number(lens.focal_length_m),
                  json_number(lens.focus_distance_m),
                  lens.focus_point ? SortedJson{json_number(lens.focus_point->x), json_number(lens.focus_point->y)}
                                   : SortedJson(),
                  lens.aperture_blades,
                  json_number(lens.aperture_rotation_rad),
                  json_number(lens.anamorphic_ratio),
                  json_number(lens.cats_eye)};
  return json;
}

void add_frame(const ImageSettings& o, const ResolvedImage& resolved, SortedJson& j) {
  const V2i& size = resolved.size_px;
  const PixelRect crop = o.crop.value_or(PixelRect{V2i(0, 0), size});
  j["--size"] = {size.x, size.y}; // times --scale
  j["--crop"] = {crop.min.x, crop.min.y, crop.max.x, crop.max.y};
  AovSet aovs = o.recorded_aovs(); // of --aov, and of --denoise
  for (const Aov always : {Aov::beauty, Aov::alpha, Aov::samples}) aovs.insert(always);
  std::vector<std::string> names;
  for (const AovInfo& info : kAovs)
    if (aovs.contains(info.aov)) names.emplace_back(info.name);
  j["--aov"] = names;
  j["--cryptomatte"] = SortedJson::array();
  for (const MatteInfo& info : kMattes)
    if (aovs.contains(info.matte)) j["--cryptomatte"].push_back(info.name);
}

void add_sampling(const ImageSettings& o, SortedJson& j) {
  j["--planned-spp"] = o.planned_samples();
  j["--noise-threshold"] = json_number(o.adaptive.noise_threshold);
  j["--min-spp"] = o.adaptive.enabled() ? SortedJson(o.adaptive.min_samples_per_pixel) : SortedJson();
  j["--sample-rates"] = sample_rates_name(o.sample_rates);
  j["--seed"] = o.seed;
  j["--sampler"] = sampler_name(o.sampler);
  const PixelFilter filter(o.filter);
  j["--filter"] = filter_name(filter.kind());
  j["--filter-width"] = json_number(filter.width());
  j["--outliers"] = outliers_name(o.outliers);
}

// The frames before and after, for motion vectors alone.
SortedJson frame_step(const FrameStep& step) {
  SortedJson json;
  json["time"] = json_number(step.time_s);
  json["turn"] = json_number(step.turn_deg);
  json["previous"] = step.previous_camera ? own_camera(*step.previous_camera) : SortedJson();
  json["next"] = step.next_camera ? own_camera(*step.next_camera) : SortedJson();
  return json;
}

void add_scene(const ImageSettings& o, const ResolvedImage& resolved, SortedJson& j) {
  j["--scene"] = resolved.scene;
  j["--variant"] = resolved.variant;
  j["--time"] = json_number(resolved.time_s); // and --frames
  j["--shutter"] = nullptr;                   // and --shutter-angle with --fps, or the camera's
  if (resolved.shutter)
    j["--shutter"] = {json_number(resolved.shutter->open_s), json_number(resolved.shutter->close_s)};
  j["--camera"] = o.own_camera      ? own_camera(*o.own_camera)
                  : resolved.camera ? SortedJson(*resolved.camera)
                                    : SortedJson();
  j["--orbit"] = json_vector(o.orbit);
  j["--target"] = o.orbit ? json_vector(o.target) : SortedJson();
  j["--turn"] = o.turn ? json_number(o.turn->angle_deg) : SortedJson(); // and --turntable
  j["--orbit-axis"] = o.turn ? json_vector(o.turn->axis) : SortedJson();
  if (o.turn) j["--target"] = json_vector(o.turn->around);
  j["--orthographic"] = o.orbit ? json_number(o.orthographic_m) : SortedJson();
  j["--fov"] = json_number(o.yfov_deg);
  j["--backfaces"] = backfaces_name(o.backfaces);
  j["--fps"] = o.aovs.needs_motion() ? frame_step(o.frame_step) : SortedJson();
  j["--shadow-catcher"] = o.shadow_catchers;
  j["--shadow-catchers"] = o.shadow_catchers_of_file ? "extras" : "off";
}

void add_lens(const LensOptions& o, SortedJson& j) {
  j["--f-stop"] = o.pinhole ? SortedJson("none") : json_number(o.f_stop);
  j["--focal-length"] = json_number(o.focal_length_mm);
  j["--focus-distance"] = json_number(o.focus_distance_m);
  j["--focus-pixel"] = pixel(o.focus_pixel);
  j["--aperture-blades"] = o.blades ? SortedJson(*o.blades) : SortedJson();
  j["--aperture-rotation"] = json_number(o.rotation_deg);
  j["--anamorphic"] = json_number(o.anamorphic_ratio);
  j["--cats-eye"] = json_number(o.cats_eye);
}

void add_light(const WorldSettings& o, const IntegratorSettings& s, const ResolvedImage& resolved, SortedJson& j) {
  const bool file = !o.env_file.empty();
  j["--env"] = file ? SortedJson(fmt::format("{:016x}", resolved.environment_hash)) : SortedJson();
  j["--env-rotation"] = file ? json_number(o.env_rotation_deg) : SortedJson();
  j["--env-intensity"] = file || o.env_color ? json_number(o.env_intensity) : SortedJson();
  j["--env-color"] = color(o.env_color);
  j["--studio"] = file || o.env_color ? SortedJson() : SortedJson(studio_name(o.studio));
  j["--light-radius"] = json_number(o.lights.radius_m);
  j["--point-size"] = json_number(o.point_size_px);
  j["--outlines"] = o.outlines;
  j["--sun-angle"] = json_number(o.lights.sun_angle_deg);
  j["--background"] = s.transparent_background ? SortedJson("transparent")
                      : s.background           ? color(s.background)
                                               : SortedJson("env");
}

void add_transport(const WorldSettings& world, const ImageSettings& o, SortedJson& j) {
  const IntegratorSettings& s = o.integrator;
  j["--integrator"] = integrator_name(s.kind);
  j["--max-bounces"] = s.max_bounces;
  j["--max-diffuse-bounces"] = s.max_diffuse_bounces;
  j["--max-glossy-bounces"] = s.max_glossy_bounces;
  j["--max-transmission-bounces"] = s.max_transmission_bounces;
  j["--roulette-start"] = s.roulette_start_bounce;
  j["--direct-samples"] = o.chooses_direct_samples ? SortedJson("auto") : SortedJson(s.direct_samples);
  j["--reflection-samples"] = o.chooses_reflection_samples ? SortedJson("auto") : SortedJson(s.reflection_samples);
  j["--path-reuse"] = o.chooses_path_reuse ? SortedJson("auto") : SortedJson(s.path_reuse);
  j["--clamp-direct"] = json_number(s.clamp_direct);
  j["--clamp-indirect"] = json_number(s.clamp_indirect);
  j["--caustics"] = caustics_name(s.caustics);
  const bool chooses_light_paths = o.chooses_light_paths && s.light_paths == 0.0f;
  j["--light-paths"] = chooses_light_paths ? SortedJson("auto") : json_number(s.light_paths);
  const bool chooses_photons = o.chooses_photons && s.photons == 0.0f;
  j["--photons"] = chooses_photons ? SortedJson("auto") : json_number(s.photons);
  j["--environment-filter"] = json_number(s.environment_filter);
  j["--manifold-samples"] = s.manifold_samples;
  j["--guiding"] = guiding_name(o.guiding);
  j["--training-paths"] = json_number(o.training_paths);
  j["--light-groups"] = light_grouping_name(s.light_groups);
  j["--ao-distance"] = json_number(s.ao_distance_m);
  j["--accel"] = accelerator_identity(world.accelerator);
  j["--accel-quality"] = accel::quality_name(world.quality);
}

// The cache and the form of the Whitted tracer are left out: they make the same pixels.
void add_whitted(const IntegratorSettings& s, SortedJson& j) {
  const bool used = s.kind == IntegratorKind::whitted;
  const WhittedSettings& w = s.whitted;
  j["--trace-depth"] = used ? SortedJson(w.trace_depth) : SortedJson();
  j["--max-reflections"] = used ? SortedJson(std::min(w.max_reflections, w.trace_depth)) : SortedJson();
  j["--ambient"] = !used       ? SortedJson()
                   : w.ambient ? color(w.ambient)
                               : SortedJson(w.environment_light ? "sampled" : "env");
  j["--light-samples"] = used ? SortedJson(w.light_strata) : SortedJson();
  j["--glossy-samples"] = used ? SortedJson(w.glossy_strata) : SortedJson();
}

} // namespace

std::string pixel_settings(const WorldSettings& world, const ImageSettings& image, const ResolvedImage& resolved) {
  SortedJson j = SortedJson::object();
  add_frame(image, resolved, j);
  add_sampling(image, j);
  add_scene(image, resolved, j);
  add_lens(image.lens, j);
  add_light(world, image.integrator, resolved, j);
  add_transport(world, image, j);
  add_whitted(image.integrator, j);
  return j.dump(-1, ' ', false, SortedJson::error_handler_t::replace);
}

} // namespace kindling
