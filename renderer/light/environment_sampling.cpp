// Samples an Environment.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/environment.h"
#include "renderer/sampling/warp.h"

#include <cassert>

namespace kindling {
namespace {

// Samples x in [0, 1) by inversion with a density that is linear from a to b, both >= 0 and not
// both 0.
float sample_linear(float u, float a, float b) {
  return std::min(u * (a + b) / (a + std::sqrt(lerp(a * a, b * b, u))), kOneMinusEpsilon);
}

} // namespace

LightSample EnvironmentView::sample(const V2f& u) const {
  assert(u.x >= 0.0f && u.x <= 1.0f && u.y >= 0.0f && u.y <= 1.0f);
  LightSample result;
  result.distance = kInfinity;
  if (is_black()) {
    result.wi = V3f(0.0f, 1.0f, 0.0f);
    return result;
  }
  if (width == 0) {
    result.wi = sample_uniform_sphere(u);
    result.radiance = constant;
    result.pdf = constant_pdf;
    return result;
  }
  // Selects a cell between four texel centers, then samples bilinearly within.
  const Distribution2D::Sample chosen = distribution.sample(u);
  const auto rows = static_cast<float>(height + 1);
  const float u_s =
      std::clamp(chosen.uv.x * static_cast<float>(width) - static_cast<float>(chosen.column), 0.0f, kOneMinusEpsilon);
  const float u_t = std::clamp(chosen.uv.y * rows - static_cast<float>(chosen.row), 0.0f, kOneMinusEpsilon);
  const Fp16Texel* upper = &texels[texel_index(static_cast<int>(chosen.column), static_cast<int>(chosen.row) - 1)];
  const Fp16Texel* lower = upper + (static_cast<size_t>(width) + 2);
  const float w00 = half_to_float(upper[0].weight), w10 = half_to_float(upper[1].weight);
  const float w01 = half_to_float(lower[0].weight), w11 = half_to_float(lower[1].weight);
  float t = sample_linear(u_t, w00 + w10, w01 + w11);
  const float s = sample_linear(u_s, lerp(w00, w01, t), lerp(w10, w11, t));
  // The weights of a half cell at a pole do not vary across it.
  if (chosen.row == 0)
    t = 0.5f + 0.5f * t;
  else if (static_cast<int>(chosen.row) == height)
    t *= 0.5f;

  float image_u = (static_cast<float>(chosen.column) + 0.5f + s) / static_cast<float>(width);
  image_u -= image_u >= 1.0f ? 1.0f : 0.0f;
  const float image_v =
      std::clamp((static_cast<float>(chosen.row) - 0.5f + t) / static_cast<float>(height), 0.0f, 1.0f);
  const SinCos theta = sincos_turns(0.5f * image_v);
  const SinCos phi = sincos_turns(image_u - 0.5f - rotation_turns);
  result.wi = V3f(theta.sin * phi.cos, theta.cos, theta.sin * phi.sin);
  const EnvironmentEval evaluated = eval(Location{image_u, image_v, theta.sin});
  result.radiance = evaluated.radiance;
  result.pdf = evaluated.pdf;
  return result;
}

void EnvironmentView::prefetch_samples(std::span<const V2f> draws) const {
  if (width == 0) return;
  distribution.prefetch(draws);
  for (const V2f& u : draws) {
    const Distribution2D::Sample cell = distribution.sample(u);
    const Fp16Texel* upper = &texels[texel_index(static_cast<int>(cell.column), static_cast<int>(cell.row) - 1)];
    kindling::prefetch(upper);
    kindling::prefetch(upper + width + 2);
  }
}

} // namespace kindling
