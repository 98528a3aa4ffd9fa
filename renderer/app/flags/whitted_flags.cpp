// Declares the flags of the Whitted tracer and applies its named configurations.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/whitted_flags.h"

#include "renderer/app/flags/scene_flags.h"
#include "renderer/app/text/parse_values.h"

#include <fmt/format.h>

namespace kindling::app {
namespace {

// Parses "8x8": as many strata on both sides.
Result<void> set_strata(std::string_view text, int& side) {
  const Result<V2i> size = parse_size(text);
  if (!size.ok() || size.value().x != size.value().y || size.value().x > WhittedSettings::kMaxStrata)
    return Error{ErrorKind::usage, fmt::format("'{}' is not a square of strata; use 1x1 to {}x{}", text,
                                               WhittedSettings::kMaxStrata, WhittedSettings::kMaxStrata)};
  side = size.value().x;
  return {};
}

Result<void> set_ambient(std::string_view text, WhittedSettings& settings) {
  settings.environment_light = text == "sampled";
  settings.ambient.reset();
  if (text == "env" || text == "sampled") return {};
  const Result<Rgb> color = parse_color(text);
  if (!color.ok())
    return Error{ErrorKind::usage,
                 fmt::format("'{}' is not an ambient light; use env, sampled or R,G,B in linear light", text)};
  settings.ambient = color.value();
  return {};
}

constexpr int kOptimizedReflections = 3; // implied by --tracer optimized

constexpr const char* kWhittedFlags[] = {"--trace-depth",    "--max-reflections", "--ambient",     "--light-samples",
                                         "--glossy-samples", "--whitted-cache",   "--whitted-form"};

} // namespace

void add_whitted_flags(FlagSet& flags, RenderOptions& o) {
  WhittedSettings& w = o.integrator.whitted;
  const auto square = [](int side) { return fmt::format("{0}x{0}", side); };
  const std::string ambient = w.ambient ? "R,G,B" : w.environment_light ? "sampled" : "env";
  flags.group("Whitted tracer");
  flags.value("--tracer", "none|kdtree|optimized",
              fmt::format("A named configuration of --integrator whitted: recursive without an accelerator or a cache "
                          "(none), the same with the kd-tree (kdtree), or iterative with kd-tree, cache and "
                          "--max-reflections {} (optimized); other flags override it [none of them]",
                          kOptimizedReflections),
              [&o](auto text) -> Result<void> {
                o.tracer = whitted_tracer_from_name(text);
                if (!o.tracer) return unknown_name("tracer", text, {"none", "kdtree", "optimized"});
                return {};
              });
  flags.value(
      "--trace-depth", "N",
      fmt::format("Maximum number of rays in a row, the camera ray included; 1: no reflections [{}]", w.trace_depth),
      [&w](auto text) { return store(parse_integer(text, 1, WhittedSettings::kMaxDepth), w.trace_depth); });
  flags.value("--max-reflections", "N",
              "Maximum number of reflections among them, without total internal ones [--trace-depth]",
              [&w](auto text) { return store(parse_integer(text, 0, WhittedSettings::kMaxDepth), w.max_reflections); });
  flags.value(
      "--ambient", "env|sampled|R,G,B",
      fmt::format("Ambient light in place of interreflection: the environment's mean (env), the environment with "
                  "shadows (sampled), or this radiance [{}]",
                  ambient),
      [&w](auto text) { return set_ambient(text, w); });
  flags.value("--light-samples", "NxN",
              fmt::format("Shadow rays to each light with an extent, one per stratum [{}]", square(w.light_strata)),
              [&w](auto text) { return set_strata(text, w.light_strata); });
  flags.value(
      "--glossy-samples", "NxN",
      fmt::format("Rays at the first rough mirror or rough glass, one per stratum [{}]", square(w.glossy_strata)),
      [&w](auto text) { return set_strata(text, w.glossy_strata); });
  flags.value(
      "--whitted-cache", "on|off",
      fmt::format("Cache the terms of local illumination that repeat, by material; does not change the image [{}]",
                  w.cache ? "on" : "off"),
      [&w](auto text) -> Result<void> {
        if (text != "on" && text != "off") return unknown_name("setting", text, {"on", "off"});
        w.cache = text == "on";
        return {};
      });
  flags.value(
      "--whitted-form", "iterative|recursive",
      fmt::format("Traverse the tree of rays by a list, many rays at once, or by recursion; does not change the "
                  "image [{}]",
                  whitted_form_name(w.form)),
      [&w](auto text) {
        return choose(whitted_form_from_name(text), w.form, "form", text, {"iterative", "recursive"});
      });
}

Result<void> apply_whitted_flags(const FlagSet& flags, RenderOptions& o) {
  WhittedSettings& w = o.integrator.whitted;
  if (o.tracer) {
    const bool optimized = *o.tracer == WhittedTracer::optimized;
    if (flags.given("--integrator") && o.integrator.kind != IntegratorKind::whitted)
      return Error{ErrorKind::usage, "--tracer: names Whitted tracers; leave it out with another --integrator"};
    o.integrator.kind = IntegratorKind::whitted;
    if (!flags.given("--accel"))
      o.accelerator = *o.tracer == WhittedTracer::none ? accel::Kind::brute_force : accel::Kind::kdtree;
    if (!flags.given("--whitted-form")) w.form = optimized ? WhittedForm::iterative : WhittedForm::recursive;
    if (!flags.given("--whitted-cache")) w.cache = optimized;
    if (!flags.given("--max-reflections") && optimized) w.max_reflections = kOptimizedReflections;
  }
  if (o.integrator.kind == IntegratorKind::whitted) return {};
  for (const char* flag : kWhittedFlags)
    if (flags.given(flag))
      return Error{ErrorKind::usage, fmt::format("{}: has no meaning without --integrator whitted or --tracer", flag)};
  return {};
}

} // namespace kindling::app
