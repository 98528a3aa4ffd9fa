// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/whitted_flags.h"

#include "renderer/app/flags/scene_flags.h"
#include "renderer/app/text/parse_values.h"

#include <fmt/format.h>

namespace kindling::app {
namespace {

// "8x8", a square.
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
                 fmt::format("'{}' is no ambient light; use env, sampled or R,G,B in linear light", text)};
  settings.ambient = color.value();
  return {};
}

constexpr const char* kWhittedFlags[] = {"--trace-depth",    "--max-reflections", "--ambient",     "--light-samples",
                                         "--glossy-samples", "--whitted-cache",   "--whitted-form"};

} // namespace

void add_whitted_flags(FlagSet& flags, RenderOptions& o) {
  WhittedSettings& w = o.integrator.whitted;
  flags.group("Whitted tracer");
  flags.value(
      "--tracer", "none|kdtree|optimized",
      "--integrator whitted by name: recursive without an accelerator or a cache, the same with the kd-tree, or "
      "iterative with kd-tree, cache and --max-reflections 3; other flags change it",
      [&o](auto text) -> Result<void> {
        o.tracer = whitted_tracer_from_name(text);
        if (!o.tracer) return unknown_name("tracer", text, {"none", "kdtree", "optimized"});
        return {};
      });
  flags.value("--trace-depth", "N", "Rays in a row, the camera's included; 1: no reflections [8]",
              [&w](auto text) { return store(parse_integer(text, 1, WhittedSettings::kMaxDepth), w.trace_depth); });
  flags.value("--max-reflections", "N", "Reflections among them, total ones not counted [as --trace-depth]",
              [&w](auto text) { return store(parse_integer(text, 0, WhittedSettings::kMaxDepth), w.max_reflections); });
  flags.value("--ambient", "env|sampled|R,G,B",
              "Light from all around in place of what diffuse surfaces send each other: the environment's mean, the "
              "environment with shadows, or this radiance [env]",
              [&w](auto text) { return set_ambient(text, w); });
  flags.value("--light-samples", "NxN", "Shadow feelers to a light with an extent, one for each stratum of it [1x1]",
              [&w](auto text) { return set_strata(text, w.light_strata); });
  flags.value("--glossy-samples", "NxN", "Rays where a rough mirror or rough glass is met first, likewise [1x1]",
              [&w](auto text) { return set_strata(text, w.glossy_strata); });
  flags.value("--whitted-cache", "on|off", "Keep what local illumination repeats, by material; same image [on]",
              [&w](auto text) -> Result<void> {
                if (text != "on" && text != "off") return unknown_name("setting", text, {"on", "off"});
                w.cache = text == "on";
                return {};
              });
  flags.value("--whitted-form", "iterative|recursive",
              "Walk the tree of rays by a list, many at once, or by recursion; same image [iterative]",
              [&w](auto text) {
                return choose(whitted_form_from_name(text), w.form, "form", text, {"iterative", "recursive"});
              });
}

Result<void> apply_whitted_flags(const FlagSet& flags, RenderOptions& o) {
  WhittedSettings& w = o.integrator.whitted;
  if (o.tracer) {
    const bool optimized = *o.tracer == WhittedTracer::optimized;
    if (flags.given("--integrator") && o.integrator.kind != IntegratorKind::whitted)
      return Error{ErrorKind::usage, "--tracer: names Whitted tracers; it does not go with another --integrator"};
    o.integrator.kind = IntegratorKind::whitted;
    if (!flags.given("--accel"))
      o.accelerator = *o.tracer == WhittedTracer::none ? accel::Kind::brute_force : accel::Kind::kdtree;
    if (!flags.given("--whitted-form")) w.form = optimized ? WhittedForm::iterative : WhittedForm::recursive;
    if (!flags.given("--whitted-cache")) w.cache = optimized;
    if (!flags.given("--max-reflections") && optimized) w.max_reflections = 3;
  }
  if (o.integrator.kind == IntegratorKind::whitted) return {};
  for (const char* flag : kWhittedFlags)
    if (flags.given(flag))
      return Error{ErrorKind::usage, fmt::format("{}: has no meaning without --integrator whitted or --tracer", flag)};
  return {};
}

} // namespace kindling::app
