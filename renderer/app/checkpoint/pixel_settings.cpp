// The settings of an image as JSON.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/checkpoint/pixel_settings.h"

#include "accel/simd_target.h"
#include "renderer/app/options/accelerator_variant.h"
#include "renderer/app/text/text_format.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <vector>

namespace kindling::app {

namespace {

using SortedJson = nlohmann::json; // keys in order

// The shortest text that gives this number back; a limit that is not there is none.
template <typename T>
SortedJson json_number(T value) {
  return std::isfinite(value) ? SortedJson::parse(fmt::format("{}", value)) : SortedJson();
}
template <typename T>
SortedJson json_number(const std::optional<T>& value) {
  return value ? json_number(*value) : SortedJson();
}
// The kd-tree's kernels agree to the bit on all processors. Embree chooses kernels by the processor, and its reciprocals are the
// approximations of whoever made that.
std::string accelerator_identity(accel::Kind kind) {
  std::string identity(accel::kind_description(kind)); // with the version of a library
  if (kind != accel::Kind::embree) return identity;
  const char* maker = __builtin_cpu_is("amd") ? "AMD" : __builtin_cpu_is("intel") ? "Intel" : "another maker";
  return fmt::format("{}, {} of {}", identity, accel::simd_target_name(accel::best_simd_target()), maker);
}

SortedJson json_vector(const V3f& v) { return {json_number(v.x), json_number(v.y), json_number(v.z)}; }
SortedJson json_vector(const std::optional<V3f>& v) { return v ? json_vector(*v) : SortedJson(); }
SortedJson color(const std::optional<Rgb>& c) {
  return c ? SortedJson{json_number(c->x), json_number(c->y), json_number(c->z)} : SortedJson();
}
SortedJson pixel(const std::optional<V2i>& p) { return p ? SortedJson{p->x, p->y} : SortedJson(); }

void add_frame(const RenderOptions& o, const ResolvedImage& resolved, SortedJson& j) {
  const V2i& size = resolved.size_px;
  const PixelRect crop = o.crop.value_or(PixelRect{V2i(0, 0), size});
  j["--size"] = {size.x, size.y}; // times --scale
  j["--crop"] = {crop.min.x, crop.min.y, crop.max.x, crop.max.y};
  AovSet aovs = o.aovs;
  for (const Aov always : {Aov::beauty, Aov::alpha, Aov::samples}) aovs.insert(always);
  std::vector<std::string> names;
  for (const AovInfo& info : kAovs)
    if (aovs.contains(info.aov)) names.emplace_back(info.name);
  j["--aov"] = names;
}

void add_sampling(const RenderOptions& o, SortedJson& j) {
  j["--planned-spp"] = o.planned_samples();
  j["--noise-threshold"] = json_number(o.adaptive.noise_threshold);
  j["--min-spp"] = o.adaptive.enabled() ? SortedJson(o.adaptive.min_samples_per_pixel) : SortedJson();
  j["--seed"] = o.seed;
  j["--sampler"] = sampler_name(o.sampler);
  const PixelFilter filter(o.filter);
  j["--filter"] = filter_name(filter.kind());
  j["--filter-width"] = json_number(filter.width());
  j["--outliers"] = outliers_name(o.outliers);
}

void add_scene(const RenderOptions& o, const ResolvedImage& resolved, SortedJson& j) {
  j["--scene"] = resolved.scene;
  j["--variant"] = resolved.variant;
  j["--time"] = json_number(resolved.time_s); // and --frames
  j["--shutter"] = nullptr;                   // and --shutter-angle with --fps, or the camera's
  if (resolved.shutter)
    j["--shutter"] = {json_number(resolved.shutter->open_s), json_number(resolved.shutter->close_s)};
  j["--camera"] = resolved.camera ? SortedJson(*resolved.camera) : SortedJson();
  j["--orbit"] = json_vector(o.orbit);
  j["--target"] = o.orbit ? json_vector(o.target) : SortedJson();
  j["--fov"] = json_number(o.yfov_deg);
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

void add_light(const RenderOptions& o, const ResolvedImage& resolved, SortedJson& j) {
  const bool file = !o.env_file.empty();
  j["--env"] = file ? SortedJson(format_hash(resolved.environment_hash)) : SortedJson();
  j["--env-rotation"] = file ? json_number(o.env_rotation_deg) : SortedJson();
  j["--env-intensity"] = file || o.env_color ? json_number(o.env_intensity) : SortedJson();
  j["--env-color"] = color(o.env_color);
  j["--light-radius"] = json_number(o.lights.radius_m);
  j["--sun-angle"] = json_number(o.lights.sun_angle_deg);
  const IntegratorSettings& s = o.integrator;
  j["--background"] = s.transparent_background ? SortedJson("transparent")
                      : s.background           ? color(s.background)
                                               : SortedJson("env");
}

void add_transport(const RenderOptions& o, SortedJson& j) {
  const IntegratorSettings& s = o.integrator;
  j["--integrator"] = integrator_name(s.kind);
  j["--max-bounces"] = s.max_bounces;
  j["--max-diffuse-bounces"] = s.max_diffuse_bounces;
  j["--max-glossy-bounces"] = s.max_glossy_bounces;
  j["--max-transmission-bounces"] = s.max_transmission_bounces;
  j["--roulette-start"] = s.roulette_start_bounce;
  j["--clamp-direct"] = json_number(s.clamp_direct);
  j["--clamp-indirect"] = json_number(s.clamp_indirect);
  j["--caustics"] = caustics_name(s.caustics);
  j["--guiding"] = guiding_name(o.guiding);
  j["--ao-distance"] = json_number(s.ao_distance_m);
  j["--accel"] = accelerator_identity(o.accelerator);
  j["--accel-quality"] = quality_name(o.quality);
}

// Whose cache and form make the same pixels.
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

std::string pixel_settings(const RenderOptions& options, const ResolvedImage& resolved) {
  SortedJson j = SortedJson::object();
  add_frame(options, resolved, j);
  add_sampling(options, j);
  add_scene(options, resolved, j);
  add_lens(options.lens, j);
  add_light(options, resolved, j);
  add_transport(options, j);
  add_whitted(options.integrator, j);
  return j.dump(-1, ' ', false, SortedJson::error_handler_t::replace);
}

} // namespace kindling::app
