// Words the refusals of settings and states.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/check_settings.h"

#include <cmath>
#include <string>
#include <string_view>

namespace kindling {
namespace {

Error refuse(std::string message) { return {ErrorKind::usage, std::move(message)}; }

std::string text_of(const PixelRect& r) {
  return std::to_string(r.min.x) + "," + std::to_string(r.min.y) + "," + std::to_string(r.max.x) + "," +
         std::to_string(r.max.y);
}

std::string text_of(const SampleRange& span) {
  return std::to_string(span.first) + " to " + std::to_string(span.end - 1);
}

std::string text_of(const V2i& size) { return std::to_string(size.x) + "x" + std::to_string(size.y); }

Result<void> check_pixels(const RenderSettings& settings) {
  const PixelRect image{V2i(0, 0), settings.size_px};
  const PixelRect crop = settings.crop.value_or(image);
  if (crop.empty() || !image.contains(crop))
    return refuse("crop " + text_of(crop) + " is not a rectangle within the image of " + text_of(settings.size_px) +
                  " pixels");
  if (!settings.region) return {};
  const PixelRect& region = *settings.region;
  if (region.empty())
    return refuse("region " + text_of(region) + ": it is empty; use no more parts than there are blocks of 8x8 pixels");
  if (!crop.contains(region)) return refuse("region " + text_of(region) + " is not within the crop " + text_of(crop));
  for (int axis = 0; axis < 2; ++axis)
    if ((region.min[axis] % kBlockSize != 0 && region.min[axis] != crop.min[axis]) ||
        (region.max[axis] % kBlockSize != 0 && region.max[axis] != crop.max[axis]))
      return refuse("region " + text_of(region) + ": its borders must be multiples of 8 or those of the crop " +
                    text_of(crop));
  return {};
}

Result<void> check_samples(const RenderSettings& settings) {
  if (settings.samples_per_pixel < 1) return refuse("samples per pixel: 0 found, at least 1 is needed");
  if (!settings.samples) return {};
  if (settings.samples->empty() || settings.samples->end > settings.samples_per_pixel)
    return refuse("samples " + text_of(*settings.samples) + ": a range within " +
                  text_of(SampleRange{0, settings.samples_per_pixel}) + " that is not empty is needed");
  if (settings.adaptive.enabled())
    return refuse(
        "samples " + text_of(*settings.samples) +
        " with a noise threshold: adaptive sampling decides by all earlier samples, so its samples cannot be " +
        "divided into ranges; divide the image");
  return {};
}

Result<void> check_bounces(const RenderSettings& settings) {
  const IntegratorSettings& s = settings.integrator;
  struct Limit {
    const char* name;
    int value, from, to;
  };
  // The default of max_transmission_bounces is a few more than the maximum of the others.
  for (const Limit& limit : {Limit{"max_bounces", s.max_bounces, 0, kMaxBounces},
                             {"max_diffuse_bounces", s.max_diffuse_bounces, 0, kMaxBounces},
                             {"max_glossy_bounces", s.max_glossy_bounces, 0, kMaxBounces},
                             {"max_transmission_bounces", s.max_transmission_bounces, 0, 2 * kMaxBounces},
                             {"roulette_start_bounce", s.roulette_start_bounce, 0, kMaxBounces},
                             {"direct_samples", s.direct_samples, 1, kMaxDirectSamples},
                             {"reflection_samples", s.reflection_samples, 0, kMaxReflectionSamples}})
    if (limit.value < limit.from || limit.value > limit.to)
      return refuse(std::string(limit.name) + " " + std::to_string(limit.value) + ": " + std::to_string(limit.from) +
                    " to " + std::to_string(limit.to) + " is needed");
  if (!(s.environment_filter >= 0.0f && s.environment_filter <= kMaxEnvironmentFilter))
    return refuse("environment_filter " + std::to_string(s.environment_filter) + ": 0 to " +
                  std::to_string(static_cast<int>(kMaxEnvironmentFilter)) + " is needed");
  return {};
}

Result<void> check_catchers(const RenderSettings& settings) {
  if (!settings.aovs.contains(Aov::shadow_catcher)) return {};
  if (needs_device(settings.device))
    return refuse("--shadow-catcher: not on the device '" + std::string(device_kind_name(settings.device)) +
                  "'; use --device cpu");
  if (settings.integrator.kind != IntegratorKind::path)
    return refuse("--shadow-catcher: the integrator '" + std::string(integrator_name(settings.integrator.kind)) +
                  "' has none; use --integrator path");
  if (settings.adaptive.enabled())
    return refuse("--shadow-catcher: not with --noise-threshold, which does not measure the noise of shadows");
  return {};
}

Result<void> check_motion(const RenderSettings& settings, const Camera& camera) {
  if (!settings.aovs.needs_motion()) return {};
  const std::string flag = settings.aovs.contains(Aov::vector) ? "--aov vector" : "--aov motion";
  if (camera.shutter_open())
    return refuse(flag + ": not with motion blur, whose pixels show many times; leave out the shutter, such as by "
                         "--shutter 0,0");
  return {};
}

Result<void> check_mattes(const RenderSettings& settings) {
  if (!settings.aovs.has_mattes()) return {};
  if (settings.integrator.kind == IntegratorKind::whitted)
    return refuse("--cryptomatte: not with --integrator whitted, whose samples are divided among surfaces; use path");
  return {};
}

Result<void> check_adaptive(const RenderSettings& settings) {
  // The negation also refuses NaN.
  if (!(settings.adaptive.noise_threshold >= 0.0 && std::isfinite(settings.adaptive.noise_threshold)))
    return refuse("noise threshold " + std::to_string(settings.adaptive.noise_threshold) +
                  ": a finite number that is not negative is needed");
  constexpr uint32_t kMinSamples = 16; // halves of fewer are too noisy to compare
  constexpr uint32_t kMaxSamples = 1U << 30;
  if (settings.adaptive.enabled() &&
      (settings.adaptive.min_samples_per_pixel < kMinSamples || settings.adaptive.min_samples_per_pixel > kMaxSamples))
    return refuse("at least " + std::to_string(settings.adaptive.min_samples_per_pixel) +
                  " samples per pixel: adaptive sampling needs a minimum of 16 to 2^30");
  return {};
}

// What AOVs need beside the World.
Result<void> check_inputs(const RenderSettings& settings) {
  if (settings.aovs.contains(Aov::shadow_catcher) && !settings.catchers)
    return refuse("--aov shadow_catcher: there is no shadow catcher; add --shadow-catcher NAME");
  if (settings.aovs.needs_motion() && !settings.motion)
    return refuse("motion vectors need RenderSettings::motion, the frames before and after");
  if (settings.aovs.has_mattes() && !settings.names)
    return refuse("mattes need RenderSettings::names, the names of the scene's objects");
  return {};
}

// Only paths on the CPU know where their light comes from.
Result<void> check_split_light(const RenderSettings& settings) {
  std::string wanted;
  if (settings.integrator.light_groups != LightGrouping::off) wanted = "--light-groups";
  for (const AovInfo& info : kAovs)
    if (settings.aovs.contains(info.aov) && is_light_pass(info.aov)) wanted = "--aov " + std::string(info.name);
  if (wanted.empty()) return {};
  if (settings.integrator.kind != IntegratorKind::path)
    return refuse(wanted + ": the integrator '" + std::string(integrator_name(settings.integrator.kind)) +
                  "' does not split its light; use --integrator path");
  return {};
}

// Refuses all but the path tracer with its caustics, without shadow catchers: for the flag of
// another way to find light.
Result<void> check_plain_paths(const RenderSettings& settings, std::string_view flag) {
  const IntegratorSettings& integrator = settings.integrator;
  const auto not_with = [flag](const std::string& what) { return refuse(std::string(flag) + ": not " + what); };
  if (integrator.kind != IntegratorKind::path)
    return not_with("with --integrator " + std::string(integrator_name(integrator.kind)) + "; use path");
  if (integrator.caustics != Caustics::full) return not_with("with --caustics off or regularized; use full");
  if (settings.aovs.contains(Aov::shadow_catcher)) return not_with("with --shadow-catcher");
  return {};
}

} // namespace

Result<void> check_sample_rates(const RenderSettings& settings) {
  if (settings.sample_rates != SampleRateKind::noise) return {};
  const auto not_with = [](const std::string& what) { return refuse("--sample-rates noise: not " + what); };
  if (settings.integrator.kind != IntegratorKind::path)
    return not_with("with --integrator " + std::string(integrator_name(settings.integrator.kind)) + "; use path");
  if (settings.adaptive.enabled()) return not_with("with --noise-threshold, which stops blocks of pixels");
  if (settings.time_limit_s) return not_with("with a time limit; use --spp");
  if (settings.aovs.contains(Aov::shadow_catcher)) return not_with("with --shadow-catcher");
  return {};
}

// Each pixel's light comes from all samples of the image.
Result<void> check_light_paths(const RenderSettings& settings, const Camera& camera) {
  const IntegratorSettings& integrator = settings.integrator;
  if (integrator.light_paths == 0.0f) return {};
  if (!(integrator.light_paths > 0.0f && integrator.light_paths <= 1.0f))
    return refuse("light paths " + std::to_string(integrator.light_paths) + ": a fraction from 0 to 1 is needed");
  const auto not_with = [](const std::string& what) { return refuse("--light-paths: not " + what); };
  if (Result<void> checked = check_plain_paths(settings, "--light-paths"); !checked) return checked;
  if (integrator.direct_samples > 1) return not_with("with --direct-samples above 1");
  if (integrator.reflection_samples > 0) return not_with("with --reflection-samples above 0");
  if (settings.outliers == Outliers::trim) return not_with("with --outliers trim; use keep");
  if (camera.is_orthographic() && camera.has_lens()) return not_with("with a lens of an orthographic camera");
  return {};
}

namespace {

// What photons do not work with.
Result<void> check_photons(const RenderSettings& settings) {
  const IntegratorSettings& integrator = settings.integrator;
  if (integrator.photons == 0.0f) return {};
  if (!(integrator.photons > 0.0f && integrator.photons <= 1.0f))
    return refuse("photons " + std::to_string(integrator.photons) + ": a fraction from 0 to 1 is needed");
  return check_plain_paths(settings, "--photons");
}

// What manifold sampling does not work with.
Result<void> check_manifold_samples(const RenderSettings& settings) {
  const IntegratorSettings& integrator = settings.integrator;
  if (integrator.manifold_samples == 0) return {};
  if (integrator.manifold_samples < 0 || integrator.manifold_samples > kMaxManifoldSamples)
    return refuse("manifold samples " + std::to_string(integrator.manifold_samples) + ": 0 to " +
                  std::to_string(kMaxManifoldSamples) + " are needed");
  const auto not_with = [](const std::string& what) { return refuse("--manifold-samples: not " + what); };
  if (Result<void> checked = check_plain_paths(settings, "--manifold-samples"); !checked) return checked;
  if (integrator.light_paths > 0.0f) return not_with("with --light-paths, which bring some of the same light; use 0");
  if (integrator.photons > 0.0f) return not_with("with --photons, which bring some of the same light; use 0");
  if (integrator.light_groups != LightGrouping::off || settings.aovs.needs_light_passes() ||
      settings.aovs.needs_lobe_colors())
    return not_with("with light groups or light passes");
  return {};
}

} // namespace

Result<void> check_path_reuse(const RenderSettings& settings, const Camera& camera) {
  const IntegratorSettings& integrator = settings.integrator;
  const int count = integrator.path_reuse;
  if (count == 1) return {};
  if (count != 2 && count != 4 && count != 8)
    return refuse("path reuse " + std::to_string(count) + ": 1, 2, 4 or 8 is needed");
  const auto not_with = [](const std::string& what) { return refuse("--path-reuse: not " + what); };
  if (Result<void> checked = check_plain_paths(settings, "--path-reuse"); !checked) return checked;
  if (integrator.light_paths > 0.0f || settings.chooses_light_paths) return not_with("with --light-paths; use 0");
  if (integrator.photons > 0.0f) return not_with("with --photons; use 0");
  if (integrator.manifold_samples > 0) return not_with("with --manifold-samples; use 0");
  if (settings.sample_rates == SampleRateKind::noise) return not_with("with --sample-rates noise; use even");
  if (integrator.max_diffuse_bounces < integrator.max_bounces || integrator.max_glossy_bounces < integrator.max_bounces)
    return not_with("with fewer diffuse or glossy bounces than --max-bounces " +
                    std::to_string(integrator.max_bounces));
  if (camera.shutter_open()) return not_with("with motion blur; leave out the shutter, such as by --shutter 0,0");
  return {};
}

Result<void> check_combination(const RenderSettings& settings, const Camera& camera) {
  constexpr int kMaxSide = 1 << 20;
  const V2i size = settings.size_px;
  if (size.x < 1 || size.y < 1 || size.x > kMaxSide || size.y > kMaxSide)
    return refuse("image size " + text_of(size) + ": each side must be 1 to 1048576 pixels");
  if (camera.size_px() != size)
    return refuse("the camera was created for " + std::to_string(camera.size_px().x) + "x" +
                  std::to_string(camera.size_px().y) + " pixels, the image has " + std::to_string(size.x) + "x" +
                  std::to_string(size.y));
  for (const auto& check : {check_pixels, check_samples, check_bounces, check_adaptive, check_sample_rates,
                            check_split_light, check_catchers, check_mattes})
    if (Result<void> checked = check(settings); !checked) return checked;
  if (Result<void> checked = check_motion(settings, camera); !checked) return checked;
  if (Result<void> checked = check_light_paths(settings, camera); !checked) return checked;
  if (Result<void> checked = check_photons(settings); !checked) return checked;
  if (Result<void> checked = check_manifold_samples(settings); !checked) return checked;
  if (Result<void> checked = check_path_reuse(settings, camera); !checked) return checked;
  if (settings.tile_size_px < kBlockSize || settings.tile_size_px % kBlockSize != 0)
    return refuse("tile size " + std::to_string(settings.tile_size_px) + ": a positive multiple of 8 pixels is needed");
  if (settings.integrator.batch_size < kBlockSize * kBlockSize ||
      settings.integrator.batch_size % (kBlockSize * kBlockSize) != 0)
    return refuse("batch size " + std::to_string(settings.integrator.batch_size) +
                  ": a positive multiple of 64 paths is needed");
  return {};
}

Result<void> check_settings(const RenderSettings& settings, const Camera& camera) {
  if (Result<void> checked = check_combination(settings, camera); !checked) return checked;
  return check_inputs(settings);
}

PixelRect rendered_pixels(const RenderSettings& settings) {
  const PixelRect wanted = settings.wanted_pixels();
  return settings.adaptive.enabled() ? AdaptiveSampling::whole_blocks(wanted, settings.size_px) : wanted;
}

PixelRect splat_area(const RenderSettings& settings) {
  const PixelRect pixels = settings.image_pixels();
  return settings.adaptive.enabled() ? AdaptiveSampling::whole_blocks(pixels, settings.size_px) : pixels;
}

Result<void> check_state(const RenderSettings& settings, const RenderState& state) {
  const PixelRect area = rendered_pixels(settings);
  const Film& film = state.film;
  if (film.size_px() != settings.size_px)
    return refuse("resuming: the state is of an image of " + text_of(film.size_px()) + " pixels, not of " +
                  text_of(settings.size_px));
  if (film.crop() != area || state.coverage.area() != area)
    return refuse("resuming: the state has pixels " + text_of(film.crop()) + ", not " + text_of(area));
  if (film.aovs().bits() != settings.aovs.bits()) return refuse("resuming: the state has other AOVs");
  if (film.trims_outliers() != (settings.outliers == Outliers::trim))
    return refuse("resuming: the state treats outliers differently");
  const bool open = settings.chooses_light_paths && settings.integrator.light_paths == 0.0f;
  if (!open && film.has_splats() != (settings.integrator.light_paths > 0.0f))
    return refuse(std::string("resuming: the state was rendered ") + (film.has_splats() ? "with" : "without") +
                  " light paths");
  if (!open && film.has_splats() && film.splat_area() != splat_area(settings))
    return refuse("resuming: the state has light paths of pixels " + text_of(film.splat_area()) + ", not " +
                  text_of(splat_area(settings)));
  if (settings.adaptive.enabled() ? !state.adaptive.fits(area) : !state.adaptive.empty())
    return refuse(std::string("resuming: the state was rendered ") +
                  (settings.adaptive.enabled() ? "without" : "with") + " adaptive sampling");
  const SampleRange wanted = settings.wanted_samples();
  for (size_t i = 0; i < state.coverage.block_count(); ++i) {
    const std::vector<SampleRange>& spans = state.coverage[i].spans;
    if (spans.empty() || (spans.front().first >= wanted.first && spans.back().end <= wanted.end)) continue;
    return refuse("resuming: the state has samples " + text_of(SampleRange{spans.front().first, spans.back().end}) +
                  ", but only " + text_of(wanted) + " are wanted");
  }
  return {};
}

} // namespace kindling
