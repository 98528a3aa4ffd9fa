// The flags of `kindling render` and `kindling info`.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/checkpoint_flags.h"
#include "renderer/app/flags/command_flags.h"
#include "renderer/app/flags/device_flag.h"
#include "renderer/app/flags/flag_set.h"
#include "renderer/app/flags/frame_flags.h"
#include "renderer/app/flags/image_flags.h"
#include "renderer/app/flags/layer_flags.h"
#include "renderer/app/flags/lens_flags.h"
#include "renderer/app/flags/light_flags.h"
#include "renderer/app/flags/part_flags.h"
#include "renderer/app/flags/scene_flags.h"
#include "renderer/app/flags/shutter_flags.h"
#include "renderer/app/flags/whitted_flags.h"
#include "renderer/app/options/accelerator_variant.h"
#include "renderer/app/options/options.h"
#include "renderer/app/text/parse_values.h"
#include "renderer/session/accumulation_file.h"

#include <fmt/format.h>

namespace kindling::app {

namespace {

std::vector<std::string> integrator_names() {
  std::vector<std::string> names;
  for (const IntegratorKind kind : all_integrators()) names.emplace_back(integrator_name(kind));
  return names;
}

std::vector<std::string> filter_names() {
  std::vector<std::string> names;
  for (const FilterKind kind :
       {FilterKind::blackman_harris, FilterKind::gaussian, FilterKind::box, FilterKind::mitchell})
    names.emplace_back(filter_name(kind));
  return names;
}

// "1.5; box 1; mitchell 4": the width of the first filter, and those that differ.
std::string default_filter_widths() {
  std::string text;
  const float first = default_filter_width(FilterKind::blackman_harris);
  for (const FilterKind kind : {FilterKind::gaussian, FilterKind::box, FilterKind::mitchell})
    if (const float width = default_filter_width(kind); width != first)
      text += fmt::format("; {} {:g}", filter_name(kind), width);
  return fmt::format("{:g}", first) + text;
}

std::vector<std::string> sampler_names() {
  std::vector<std::string> names;
  for (const SamplerKind kind :
       {SamplerKind::blue_noise, SamplerKind::sobol, SamplerKind::jittered, SamplerKind::independent})
    names.emplace_back(sampler_name(kind));
  return names;
}

Result<void> set_background(std::string_view text, IntegratorSettings& settings) {
  settings.background.reset();
  settings.transparent_background = text == "transparent";
  if (text == "env" || text == "transparent") return {};
  Result<Rgb> color = parse_color(text);
  if (!color.ok())
    return Error{ErrorKind::usage,
                 fmt::format("'{}' is not a background; use env, transparent or R,G,B in linear light", text)};
  settings.background = color.value();
  return {};
}

void add_image_flags(FlagSet& flags, RenderOptions& o) {
  flags.group("Image");
  add_output_flag(flags, o, "SCENE's name with .png, in the current folder");
  add_size_flag(flags, o);
  flags.value("--scale", "FACTOR", fmt::format("Factor on the image size, such as 0.5 or 50% [{:g}]", o.scale),
              [&o](auto text) { return store(parse_scale(text), o.scale); });
  flags.value("--crop", "X0,Y0,X1,Y1",
              "Render only these pixels, counted from the top left of the whole image, X1 and Y1 excluded [all]",
              [&o](auto text) { return store(parse_crop(text), o.crop); });
  add_layer_flags(flags, o.aovs);
  add_shadow_catcher_flags(flags, o);
  add_light_groups_flag(flags, o.integrator);
  add_image_format_flags(flags, o);
}

void add_sampling_flags(FlagSet& flags, RenderOptions& o) {
  flags.group("Sampling");
  flags.value(
      "--spp", "N",
      fmt::format(
          "Samples per pixel; the maximum with --noise-threshold [{}; {} with --noise-threshold; unlimited with "
          "--time-limit]",
          kDefaultSamplesPerPixel, kDefaultMaxSamplesPerPixel),
      [&o](auto text) { return store(parse_integer(text, 1, kUnlimitedSamplesPerPixel), o.spp); });
  flags.value(
      "--planned-spp", "N",
      "Sample count that the sampling pattern is designed for; keep it when adding samples or rendering parts [--spp]",
      [&o](auto text) { return store(parse_integer(text, 1, kUnlimitedSamplesPerPixel), o.planned_spp); });
  flags.value(
      "--noise-threshold", "T",
      fmt::format("Adaptive sampling: stop at a block of 8 x 8 pixels once its relative error is below T, such as "
                  "0.1; 0: never [{:g}]",
                  o.adaptive.noise_threshold),
      [&o](auto text) { return store(parse_number(text, 0.0, 1.0), o.adaptive.noise_threshold); });
  const std::string min_spp =
      fmt::format("Minimum samples per pixel with --noise-threshold [{}]", o.adaptive.min_samples_per_pixel);
  flags.value("--min-spp", "N", min_spp, [&o](auto text) {
    return store(parse_integer(text, 16, kUnlimitedSamplesPerPixel), o.adaptive.min_samples_per_pixel);
  });
  flags.value("--sample-rates", "auto|even|noise",
              fmt::format("Samples of pixels: the same for all, or more where a pilot finds more noise, in the time of "
                          "--spp for all; auto: where that pays off [{}]",
                          sample_rates_name(o.sample_rates)),
              [&o](auto text) {
                return choose(sample_rates_from_name(text), o.sample_rates, "kind of sample rates", text,
                              {"auto", "even", "noise"});
              });
  flags.value("--time-limit", "TIME",
              "Render for this time, in seconds or as in 90s, 5m, 1h30m; at most a tenth of it trains a guide [none]",
              [&o](auto text) { return store(parse_duration(text), o.time_limit_s); });
  flags.value("--time-limit-total", "TIME",
              "The same from the start of the program until the image is written: loading, building, denoising and "
              "writing count [none]",
              [&o](auto text) { return store(parse_duration(text), o.time_limit_total_s); });
  flags.value("--seed", "N", fmt::format("Random seed: changes the noise, not the image [{}]", o.seed),
              [&o](auto text) { return store(parse_integer(text, 0, std::numeric_limits<int32_t>::max()), o.seed); });
  flags.value("--sampler", "NAME",
              fmt::format("Sampling pattern: {} [{}]", join_choices(sampler_names()), sampler_name(o.sampler)),
              [&o](auto text) { return choose(sampler_from_name(text), o.sampler, "sampler", text, sampler_names()); });
  flags.value(
      "--filter", "NAME",
      fmt::format("Pixel filter: {} [{}]", join_choices(filter_names()), filter_name(o.filter.kind)),
      [&o](auto text) { return choose(filter_from_name(text), o.filter.kind, "filter", text, filter_names()); });
  flags.value("--filter-width", "PIXELS", fmt::format("Full width of the pixel filter [{}]", default_filter_widths()),
              [&o](auto text) { return store(parse_number(text, 0.01, 64.0), o.filter.width); });
  flags.value(
      "--outliers", "keep|trim",
      fmt::format("Outlying samples of a pixel: keep them, or trim them to remove fireflies; trim is biased [{}]",
                  outliers_name(o.outliers)),
      [&o](auto text) {
        return choose(outliers_from_name(text), o.outliers, "treatment of outliers", text, {"keep", "trim"});
      });
}

constexpr int64_t kMaxTrainingPaths = 1 << 24;
constexpr int kMoreTransmissions = 8; // default of --max-transmission-bounces, above --max-bounces

void add_integrator_flags(FlagSet& flags, RenderOptions& o) {
  IntegratorSettings& s = o.integrator;
  flags.group("Light transport");
  flags.value(
      "--integrator", "NAME",
      fmt::format("Integrator or debug view: {} [{}]", join_choices(integrator_names()), integrator_name(s.kind)),
      [&s](auto text) { return choose(integrator_from_name(text), s.kind, "integrator", text, integrator_names()); });
  flags.value(
      "--max-bounces", "N",
      fmt::format("Maximum number of reflections after the first surface; 0: direct light only [{}]", s.max_bounces),
      [&s](auto text) { return store(parse_integer(text, 0, kMaxBounces), s.max_bounces); });
  flags.value("--max-diffuse-bounces", "N", "Maximum number of diffuse ones among them [--max-bounces]",
              [&s](auto text) { return store(parse_integer(text, 0, kMaxBounces), s.max_diffuse_bounces); });
  flags.value("--max-glossy-bounces", "N", "Maximum number of glossy ones among them [--max-bounces]",
              [&s](auto text) { return store(parse_integer(text, 0, kMaxBounces), s.max_glossy_bounces); });
  flags.value(
      "--max-transmission-bounces", "N",
      fmt::format("Maximum number of transmissions, counted separately [--max-bounces + {}]", kMoreTransmissions),
      [&s](auto text) { return store(parse_integer(text, 0, kMaxBounces), s.max_transmission_bounces); });
  flags.value("--roulette-start", "N",
              fmt::format("First bounce with Russian roulette, not counting transmissions and narrow reflections [{}]",
                          s.roulette_start_bounce),
              [&s](auto text) { return store(parse_integer(text, 1, kMaxBounces), s.roulette_start_bounce); });
  flags.value("--clamp-direct", "RADIANCE",
              "Clamp each component of a sample's direct light to this value; biased [no limit]",
              [&s](auto text) { return store(parse_number(text, 0.0), s.clamp_direct); });
  flags.value("--clamp-indirect", "RADIANCE",
              "Clamp each component of a sample's indirect light, likewise; biased [no limit]",
              [&s](auto text) { return store(parse_number(text, 0.0), s.clamp_indirect); });
  flags.value("--caustics", "full|regularized|off",
              fmt::format("Light through smooth surfaces after a diffuse bounce: full, regularized by widened lobes, "
                          "or off; the latter "
                          "two are biased [{}]",
                          caustics_name(s.caustics)),
              [&s](auto text) {
                return choose(caustics_from_name(text), s.caustics, "treatment of caustics", text,
                              {"full", "regularized", "off"});
              });
  add_direct_samples_flag(flags, o);
  add_reflection_samples_flag(flags, o);
  add_path_reuse_flag(flags, o);
  add_light_paths_flag(flags, o);
  add_photons_flag(flags, o);
  add_environment_filter_flag(flags, o.integrator);
  add_manifold_samples_flag(flags, o.integrator);
  flags.value("--guiding", "MODE",
              fmt::format("Path guiding, trained before the image: on, off, or auto, where it pays [{}]",
                          guiding_name(o.guiding)),
              [&o](auto text) {
                return choose(guiding_from_name(text), o.guiding, "guiding", text, {"on", "off", "auto"});
              });
  flags.value(
      "--training-paths", "N",
      "Paths that train the guide; 0: no guide [a sixteenth of --planned-spp, at most 262144; with a time limit "
      "what a tenth of it allows]",
      [&o](auto text) { return store(parse_integer(text, 0, kMaxTrainingPaths), o.training_paths); });
  flags.value("--ao-distance", "METERS", "Maximum distance of ambient occluders [a tenth of the scene's diagonal]",
              [&s](auto text) { return store(parse_number(text, 1e-6), s.ao_distance_m); });
}

void add_machine_flags(FlagSet& flags, RenderOptions& o) {
  flags.group("Machine");
  add_device_flag(flags, o.device, device_kind_name(o.device));
  add_device_memory_flag(flags, o.device_memory_bytes, "what the device has");
  flags.value("--threads", "N",
              fmt::format("Threads for loading, building and rendering; 0: all cores [{}]", o.threads),
              [&o](auto text) { return store(parse_integer(text, 0, 1024), o.threads); });
  flags.value(
      "--accel", "NAME",
      fmt::format("Accelerator: kdtree, embree or brute-force, also called none [{}]", accel::kind_name(o.accelerator)),
      [&o](auto text) {
        return choose(text == "none" ? accel::Kind::brute_force : accel::kind_from_name(text), o.accelerator,
                      "accelerator", text, {"kdtree", "embree", "brute-force"});
      });
  const std::string quality =
      fmt::format("Build quality of the accelerator: fast, balanced or best [{}]", accel::quality_name(o.quality));
  flags.value("--accel-quality", "NAME", quality, [&o](auto text) {
    return choose(accel::quality_from_name(text), o.quality, "quality", text, {"fast", "balanced", "best"});
  });
  flags.value("--tile-size", "PIXELS",
              fmt::format("Side of a tile, a multiple of 8; does not change the image [{}]", o.tile_size_px),
              [&o](auto text) -> Result<void> {
                Result<int64_t> size = parse_integer(text, kBlockSize, 1024);
                if (size.ok() && size.value() % kBlockSize != 0)
                  return Error{ErrorKind::usage, fmt::format("'{}' is not a multiple of {}; use one, such as 16 or 32",
                                                             text, kBlockSize)};
                return store(std::move(size), o.tile_size_px);
              });
  flags.value(
      "--schedule", "tiles|regions",
      fmt::format("Distribution of work: tiles to whichever thread is free, or one rectangle per thread; does not "
                  "change the image [{}]",
                  schedule_name(o.schedule)),
      [&o](auto text) {
        return choose(schedule_from_name(text), o.schedule, "schedule", text, {"tiles", "regions"});
      });
  flags.value("--batch-size", "N",
              fmt::format("Paths that a thread advances together, a multiple of 64 [{}]", o.integrator.batch_size),
              [&o](auto text) { return set_batch_size(text, o.integrator.batch_size); });
  flags.value(
      "--texture-memory", "SIZE",
      "Limit on the memory of textures, such as 512M or 2G: larger sets are paged from temporary files; does not "
      "change the image [no limit]",
      [&o](auto text) { return store(parse_bytes(text), o.texture_memory_bytes); });
}

void add_report_flags(FlagSet& flags, RenderOptions& o) {
  flags.group("Reports");
  flags.value("--progress", "MODE",
              fmt::format("Progress display: auto (a status line on a terminal, else plain), plain, json or none [{}]",
                          progress_mode_name(o.progress)),
              [&o](auto text) {
                return choose(progress_mode_from_name(text), o.progress, "progress mode", text,
                              {"auto", "plain", "json", "none"});
              });
  flags.value("--stats", "FILE.json", "Write times, ray counts and memory as JSON [none]",
              [&o](auto text) { return set_path(text, o.stats_file); });
  flags.toggle("--tev", "Show the growing image in the viewer tev, which must be running on this machine",
               [&o] { o.tev.emplace(); });
  flags.value("--tev-host", "HOST[:PORT]", "The same, of a tev that listens there; port 14158 if none is given [none]",
              [&o](auto text) { return store(parse_tev_address(text), o.tev); });
  flags.value("--pixel", "X,Y", "Replay one sample of this pixel and print its path instead of writing an image",
              [&o](auto text) { return store(parse_pixel(text), o.replay_pixel); });
  const std::string sample = fmt::format("Sample of --pixel to replay, counted from 0 [{}]", o.replay_sample);
  flags.value("--sample", "N", sample, [&o](auto text) {
    return store(parse_integer(text, 0, std::numeric_limits<uint32_t>::max() - 1), o.replay_sample);
  });
  flags.toggle("-q,--quiet", "Print errors only", o.quiet);
  flags.toggle("-v,--verbose", "Print details too", o.verbose);
}

} // namespace

void add_render_flags(FlagSet& flags, RenderOptions& options) {
  add_image_flags(flags, options);
  add_sampling_flags(flags, options);
  add_scene_flags(flags, options);
  flags.value("--background", "env|transparent|R,G,B",
              "Background of the image: the environment, transparency, or a radiance [env]",
              [&options](auto text) { return set_background(text, options.integrator); });
  flags.value(
      "--backfaces", "show|cull|auto",
      fmt::format("Backs of single-sided faces for camera rays: show, cull, or auto, which culls where they are "
                  "in the way of much else, as for a room seen from outside [{}]",
                  backfaces_name(options.backfaces)),
      [&options](auto text) {
        return choose(backfaces_from_name(text), options.backfaces, "treatment of backs", text,
                      {"show", "cull", "auto"});
      });
  add_lens_flags(flags, options.lens);
  add_shutter_flags(flags, options);
  add_frame_flags(flags, options);
  add_integrator_flags(flags, options);
  add_whitted_flags(flags, options);
  add_machine_flags(flags, options);
  add_part_flags(flags, options.part);
  add_checkpoint_flags(flags, options.checkpoint);
  add_report_flags(flags, options);
}

Result<void> check_render_flags(const FlagSet& flags, RenderOptions& o) {
  if (o.scene_file.empty())
    return usage_error("no scene; use 'kindling render SCENE [-o FILE]...' with a .gltf or .glb file");
  if (Result<void> checked = check_scene_flags(flags, o); !checked.ok()) return checked;
  if (Result<void> checked = check_lens_flags(flags, o.lens); !checked.ok()) return checked;
  if (Result<void> checked = check_shutter_flags(flags, o); !checked.ok()) return checked;
  if (Result<void> checked = check_frame_flags(flags, o); !checked.ok()) return checked;
  if (o.time_limit_total_s && o.time_limit_s)
    return usage_error("--time-limit and --time-limit-total: give one of them");
  if (o.time_limit_total_s) o.time_limit_s = o.time_limit_total_s; // less what is over when the render begins
  if (flags.given("--training-paths") && o.guiding == Guiding::off)
    return usage_error("--training-paths: has no meaning with --guiding off");
  if (o.tev && o.replay_pixel) return usage_error("--tev: has no meaning with --pixel, which writes no image");
  if (flags.given("--sample") && !o.replay_pixel) return usage_error("--sample: has no meaning without --pixel");
  if (flags.given("--min-spp") && !o.adaptive.enabled())
    return usage_error("--min-spp: has no meaning without --noise-threshold above 0");
  if (o.adaptive.enabled() && o.adaptive.min_samples_per_pixel > o.samples_per_pixel())
    return usage_error(
        fmt::format("--noise-threshold: --spp {} is below --min-spp {}; use a larger --spp or a smaller --min-spp",
                    o.samples_per_pixel(), o.adaptive.min_samples_per_pixel));
  if (Result<void> checked = check_device_memory(o.device, o.device_memory_bytes); !checked.ok()) return checked;
  if (Result<void> checked = check_part_flags(o); !checked.ok()) return checked;
  if (Result<void> checked = check_layer_flags(flags, o); !checked.ok()) return checked;
  if (Result<void> checked = check_checkpoint_flags(flags, o); !checked.ok()) return checked;
  if (o.quiet && o.verbose) return usage_error("--quiet and --verbose: give one of them");

  IntegratorSettings& s = o.integrator;
  if (Result<void> applied = apply_whitted_flags(flags, o); !applied.ok()) return applied;
  if (!flags.given("--max-diffuse-bounces")) s.max_diffuse_bounces = s.max_bounces;
  if (!flags.given("--max-glossy-bounces")) s.max_glossy_bounces = s.max_bounces;
  if (!flags.given("--max-transmission-bounces")) s.max_transmission_bounces = s.max_bounces + kMoreTransmissions;
  return {};
}

void add_info_flags(FlagSet& flags, InfoOptions& o) {
  const auto topic = [&](const char* name, const char* description, InfoTopic value) {
    flags.toggle(name, description, [&o, value] { o.topic = value; });
  };
  flags.group("What to print");
  topic("--list-cameras", "Cameras of the scene, one per line: index, name, kind", InfoTopic::cameras);
  topic("--list-scenes", "Scenes, one per line: index, name", InfoTopic::scenes);
  topic("--list-variants", "Material variants, one name per line", InfoTopic::variants);
  topic("--list-extensions", "Supported glTF extensions, one name per line; needs no SCENE", InfoTopic::extensions);
  topic("--extension-table", "The same as a Markdown table with levels of support and notes, as in the README",
        InfoTopic::extension_table);
  flags.value("--scene", "NAME|INDEX", "Scene whose cameras, triangles and bounds are printed [the file's default]",
              [&o](auto text) { return set_text(text, o.scene_name); });
  flags.value("--variant", "NAME|INDEX", "Variant whose materials are counted [the primitives' own materials]",
              [&o](auto text) { return set_text(text, o.variant_name); });
  flags.toggle("--follow-links", "Also read files of the scene behind symbolic links that lead out of its folder",
               o.image.follow_links);
  flags.group("Image of the memory estimate");
  add_size_flag(flags, o.image);
  add_layer_estimate_flags(flags, o.image.aovs);
  add_light_groups_flag(flags, o.image.integrator);
  add_light_paths_flag(flags, o.image);
  add_photons_flag(flags, o.image);
  add_environment_filter_flag(flags, o.image.integrator);
  flags.value(
      "--denoise", "off|fast|best", fmt::format("Denoising [{}]", denoising_name(o.image.denoising)), [&o](auto text) {
        return choose(denoising_from_name(text), o.image.denoising, "way of denoising", text, {"off", "fast", "best"});
      });
  flags.value("--env", "FILE", "Environment map [none]", [&o](auto text) { return set_path(text, o.image.env_file); });
  flags.value("--texture-memory", "SIZE", "Limit on the memory of textures [no limit]",
              [&o](auto text) { return store(parse_bytes(text), o.image.texture_memory_bytes); });
  flags.group("Check");
  flags.toggle("--strict", "Refuse every fault that a render repairs with a warning: one line, exit code 3", o.strict);
  flags.group("Output");
  flags.toggle("--json", "Print JSON instead of tables", o.json);
  flags.value("--threads", "N",
              fmt::format("Threads for loading, and of the memory estimate; 0: all cores [{}]", o.threads),
              [&o](auto text) { return store(parse_integer(text, 0, 1024), o.threads); });
}

Result<void> check_info_flags(const FlagSet& flags, const InfoOptions& options) {
  int topics = 0;
  for (const char* name :
       {"--list-cameras", "--list-scenes", "--list-variants", "--list-extensions", "--extension-table"})
    topics += flags.given(name) ? 1 : 0;
  if (topics > 1) return usage_error("give only one --list-... flag or --extension-table");
  if (options.scene_file.empty() && options.topic != InfoTopic::extensions &&
      options.topic != InfoTopic::extension_table)
    return usage_error("no scene and no .kacc file; use 'kindling info FILE' with a .gltf, .glb or .kacc file, or "
                       "--list-extensions");
  if (!names_accumulation(options.scene_file)) return {};
  for (const std::string& name : flags.names())
    if (name != "--json" && name != "--threads" && flags.given(name))
      return usage_error(
          fmt::format("{}: has no meaning with {}, which is not a scene", name, options.scene_file.string()));
  return {};
}

} // namespace kindling::app
