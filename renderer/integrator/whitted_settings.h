// What the Whitted tracer can be told: depth, samples of its effects, and its four optimizations.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstdint>
#include <optional>
#include <string_view>

namespace kindling {

enum class WhittedForm : uint8_t {
  iterative, // rays of many tree nodes wait in a list and are traced together
  recursive, // one ray after the other, on the program's stack; the same image to the bit
};
[[nodiscard]] constexpr std::string_view whitted_form_name(WhittedForm form) {
  return form == WhittedForm::iterative ? "iterative" : "recursive";
}
[[nodiscard]] constexpr std::optional<WhittedForm> whitted_form_from_name(std::string_view name) {
  for (const WhittedForm form : {WhittedForm::iterative, WhittedForm::recursive})
    if (whitted_form_name(form) == name) return form;
  return std::nullopt;
}

// Settings with names, to compare: which accelerator, form, cache and limit they stand for is the application's to know.
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
  static constexpr int kMaxStrata = 32; // on a side

  int trace_depth = 8; // rays in a row, the camera's included, in [1, kMaxDepth]; 1: nothing is reflected or refracted
  // Reflections among them, in [0, kMaxDepth]. Total reflection is none: it is the only way on.
  int max_reflections = kMaxDepth;
  // Radiance from all sides that the light transported by no ray stands for; unset: the mean of the environment, black without one.
  std::optional<Rgb> ambient;
  // The environment is a light like others, with shadow feelers, and `ambient` is black unless it is set.
  bool environment_light = false;
  int light_strata = 1;  // n: n x n shadow feelers, one for each stratum, per light with an extent, in [1, kMaxStrata]
  int glossy_strata = 1; // n: n x n rays where a tree first meets a rough mirror or rough glass, in [1, kMaxStrata]
  // Lights that no ray can meet are seen in surfaces as if these were at least this rough: or nobody would see the highlight in a mirror.
  float highlight_roughness = 0.2f;
  bool cache = true;
  WhittedForm form = WhittedForm::iterative;
};

} // namespace kindling
