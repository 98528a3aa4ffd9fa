// Khronos PBR Neutral tone mapper.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

namespace kindling {

// Maps scene-linear Rec. 709 to display-linear Rec. 709 in [0, 1) (Khronos PBR Neutral Tone Mapper,
// "PBR Neutral Specification", github.com/KhronosGroup/ToneMapping, PBR_Neutral). Negative
// components are outside of the domain of the formula and count as 0.
[[nodiscard]] inline Rgb tone_map_pbr_neutral(const Rgb& scene) {
  constexpr float kF90 = 0.04f;          // reflection at normal incidence of an index of refraction of 1.5
  constexpr float kStart = 0.8f - kF90;  // K_s: start of the compression of highlights
  constexpr float kDesaturation = 0.15f; // K_d
  const Rgb c{std::max(0.0f, scene.x), std::max(0.0f, scene.y), std::max(0.0f, scene.z)}; // NaN becomes 0
  const float x = min_component(c);
  const float f = x <= 2.0f * kF90 ? x - x * x / (4.0f * kF90) : kF90;
  const Rgb shifted = c - Rgb(f);
  const float peak = max_component(shifted);
  if (peak <= kStart) return shifted;
  if (!std::isfinite(peak)) return Rgb(1.0f);
  const float new_peak = 1.0f - square(1.0f - kStart) / (peak + 1.0f - 2.0f * kStart);
  const float g = 1.0f / (kDesaturation * (peak - new_peak) + 1.0f);
  return shifted * (new_peak / peak * g) + Rgb(new_peak * (1.0f - g));
}

} // namespace kindling
