// Settings of the Whitted tracer: depth, distributed samples, and its four optimizations.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstdint>
#include <optional>
#include <string_view>

namespace kindling {

enum class WhittedForm : uint8_t {
  iterative, // a work list; rays of many nodes are traced together
  recursive, // one ray at a time, on the program's stack; the same image to the bit
};
[[nodiscard]] constexpr std::string_view whitted_form_name(WhittedForm form) {
  return form == WhittedForm::iterative ? "iterative" : "recursive";
}
[[nodiscard]] constexpr std::optional<WhittedForm> whitted_form_from_name(std::string_view name) {
  for (const WhittedForm form : {WhittedForm::iterative, WhittedForm::recursive})
    if (whitted_form_name(form) == name) return form;
  return std::nullopt;
}

// Named presets for comparisons. The application maps them to accelerator, form, cache and
// reflection limit.
enum class WhittedTracer : uint8_t { none, kdtree, optimized };
[[nodiscard]] constexpr std::string_view whitted_tracer_name(WhittedTracer tracer) {
  return tracer == WhittedTracer::none ? "none" : tracer == WhittedTracer::kdtree ? "kdtree" : "optimized";
}
[[nodiscard]] constexpr std::optional<WhittedTracer> whitted_tracer_from_name(std::string_view name) {
  for (const WhittedTracer tracer : {WhittedTracer::none, WhittedTracer::kdtree, WhittedTracer::optimized})
    if (whitted_tracer_name(tracer) == name) return tracer;
  return std::nullopt;
}

struct WhittedSettings {
  static constexpr int kMaxDepth = 64;
  static constexpr int kMaxStrata = 32; // along one side

  int trace_depth = 8; // rays in a row, the camera's included, in [1, kMaxDepth]; 1: nothing is reflected or refracted
  // Maximum of reflections among them, in [0, kMaxDepth]. Total reflection does not count: it is
  // the only continuation.
  int max_reflections = kMaxDepth;
  // Radiance from all directions in place of untraced light; unset: the environment's mean, black
  // without one.
  std::optional<Rgb> ambient;
  // The environment is sampled as a light, with shadow feelers; then `ambient` is black unless it
  // is set.
  bool environment_light = false;
  int light_strata = 1;  // n: n x n shadow feelers, one for each stratum, per light with an extent, in [1, kMaxStrata]
  int glossy_strata = 1; // n: n x n rays where a tree first meets a rough mirror or rough glass, in [1, kMaxStrata]
  // Minimum roughness of surfaces for lights that no ray can hit: their highlights in mirrors would
  // be invisible otherwise.
  float highlight_roughness = 0.2f;
  bool cache = true;
  WhittedForm form = WhittedForm::iterative;
};

} // namespace kindling
