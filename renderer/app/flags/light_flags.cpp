// Declares the flags of light sampling, light paths, photons and light groups.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/light_flags.h"

#include "renderer/app/flags/flag_set.h"
#include "renderer/app/flags/scene_flags.h"
#include "renderer/app/text/parse_values.h"

#include <fmt/format.h>

#include <string>

namespace kindling::app {
namespace {

// Sets a fraction that a pilot may choose, which is 0 until then.
Result<void> set_fraction(std::string_view text, bool& chooses, float& value) {
  chooses = text == "auto";
  value = 0.0f;
  if (chooses) return {};
  Result<double> fraction = parse_number(text, 0.0, 1.0);
  if (!fraction.ok())
    return Error{ErrorKind::usage, fmt::format("'{}' is neither auto nor a number from 0 to 1", text)};
  return store(std::move(fraction), value);
}

// Sets a number that a pilot may choose, which has the first value until then.
Result<void> set_count(std::string_view text, int from, int to, bool& chooses, int& count) {
  chooses = text == "auto";
  count = from;
  if (chooses) return {};
  Result<int64_t> samples = parse_integer(text, from, to);
  if (!samples.ok())
    return Error{ErrorKind::usage,
                 fmt::format("'{}' is neither auto nor a whole number from {} to {}", text, from, to)};
  return store(std::move(samples), count);
}

Result<void> set_path_reuse(std::string_view text, ImageSettings& o) {
  o.chooses_path_reuse = text == "auto";
  o.integrator.path_reuse = 1;
  if (o.chooses_path_reuse) return {};
  for (const int count : {1, 2, 4, 8})
    if (text == std::to_string(count)) {
      o.integrator.path_reuse = count;
      return {};
    }
  return Error{ErrorKind::usage, fmt::format("'{}' is not auto, 1, 2, 4 or 8", text)};
}

} // namespace

void add_light_flags(FlagSet& flags, LightOptions& o) {
  flags.value("--light-radius", "METERS",
              "Radius of point and spot lights that have none in the file, for soft shadows [0]",
              [&o](auto text) { return store(parse_number(text, 0.0, 1e9), o.radius_m); });
  flags.value("--sun-angle", "DEG",
              "Angular diameter of directional lights that have none in the file, degrees; the sun's is 0.53 [0]",
              [&o](auto text) { return store(parse_number(text, 0.0, 180.0), o.sun_angle_deg); });
}

void add_direct_samples_flag(FlagSet& flags, ImageSettings& o) {
  flags.value("--direct-samples", "auto|N",
              fmt::format("Samples of lights at the first surface of a path, with a shadow ray each; auto: as many as "
                          "pay off, by a short pilot [{}]",
                          o.chooses_direct_samples ? "auto" : "1"),
              [&o](auto text) {
                return set_count(text, 1, kMaxDirectSamples, o.chooses_direct_samples, o.integrator.direct_samples);
              });
}

void add_reflection_samples_flag(FlagSet& flags, ImageSettings& o) {
  flags.value("--reflection-samples", "auto|N",
              fmt::format("Samples of the environment that a coat or another glossy lobe of a path's first surface "
                          "reflects, with a shadow ray each; auto: as many as pay off, by the same pilot [{}]",
                          o.chooses_reflection_samples ? "auto" : "0"),
              [&o](auto text) {
                return set_count(text, 0, kMaxReflectionSamples, o.chooses_reflection_samples,
                                 o.integrator.reflection_samples);
              });
}

void add_path_reuse_flag(FlagSet& flags, ImageSettings& o) {
  flags.value("--path-reuse", "auto|N",
              fmt::format("Share what paths find after their second surface between 2, 4 or 8 pixels, for less noise "
                          "in indirect light; 1: none; auto: as many as pay off, by a short pilot [{}]",
                          o.chooses_path_reuse ? "auto" : "1"),
              [&o](auto text) { return set_path_reuse(text, o); });
}

void add_light_paths_flag(FlagSet& flags, ImageSettings& o) {
  flags.value("--light-paths", "auto|FRACTION",
              fmt::format("Trace light paths over glass, metal and coats, too, for this fraction of the samples; auto: "
                          "for as many as pay off, by a short pilot [{}]",
                          o.chooses_light_paths ? "auto" : "0"),
              [&o](auto text) { return set_fraction(text, o.chooses_light_paths, o.integrator.light_paths); });
}

void add_photons_flag(FlagSet& flags, ImageSettings& o) {
  flags.value(
      "--photons", "auto|FRACTION",
      fmt::format("Gather photons where caustics are seen, also in mirrors and through glass: this many for each "
                  "sample of a pixel; 0: none; auto: as many as pay off, by a short pilot. Blurs caustics by "
                  "about a pixel, less with more samples [{}]",
                  o.chooses_photons ? "auto" : "0"),
      [&o](auto text) { return set_fraction(text, o.chooses_photons, o.integrator.photons); });
}

void add_environment_filter_flag(FlagSet& flags, IntegratorSettings& s) {
  flags.value("--environment-filter", "PIXELS",
              "Average what glass and mirrors show of the environment over this many pixels divided by the number of "
              "samples, for less noise behind uneven glass; 0: not [1]",
              [&s](auto text) { return store(parse_number(text, 0.0, kMaxEnvironmentFilter), s.environment_filter); });
}

void add_manifold_samples_flag(FlagSet& flags, IntegratorSettings& s) {
  flags.value("--manifold-samples", "N",
              "Look for the light that lamps without a size throw through smooth glass and off it, at each surface; 0: "
              "not, and such light is missing [0]",
              [&s](auto text) { return store(parse_integer(text, 0, kMaxManifoldSamples), s.manifold_samples); });
}

void add_light_groups_flag(FlagSet& flags, IntegratorSettings& s) {
  flags.value("--light-groups", "off|kind|name|extras",
              fmt::format("Layers of EXR files by light group, for 'kindling relight': by the kind of light "
                          "(environment, suns, lights, emissive), by name, or by the scene's extras [{}]",
                          light_grouping_name(s.light_groups)),
              [&s](auto text) {
                return choose(light_grouping_from_name(text), s.light_groups, "way of grouping lights", text,
                              {kLightGroupingNames.begin(), kLightGroupingNames.end()});
              });
}

} // namespace kindling::app
