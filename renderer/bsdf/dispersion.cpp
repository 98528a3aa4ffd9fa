// Index of refraction by wavelength, and wavelength sampling from a table.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/dispersion.h"

#include <cassert>

namespace kindling {

namespace {

// Fraunhofer's lines F, d and C, in nm.
constexpr double kF = 486.1;
constexpr double kD = 587.6;
constexpr double kC = 656.3;
constexpr double kSpread = 1.0 / (kF * kF) - 1.0 / (kC * kC);

} // namespace

float dispersed_ior(float ior, float dispersion, float nm) {
  assert(dispersion >= 0.0f && nm > 0.0f);
  // n - n_d = (n_d - 1) / V (1 / lambda^2 - 1 / lambda_d^2) / (1 / lambda_F^2 - 1 / lambda_C^2)
  constexpr auto kScale = static_cast<float>(1.0 / kSpread / 20.0);
  constexpr auto kOffset = static_cast<float>(1.0 / (kD * kD) / kSpread / 20.0);
  return std::max(ior + (ior - 1.0f) * dispersion * (kScale / (nm * nm) - kOffset), 1.0f);
}

WavelengthSample sample_wavelength(float u) {
  assert(u >= 0.0f && u <= 1.0f);
  const float x = u * (kWavelengthNodes - 1);
  const uint32_t i = cell_of(x, kWavelengthNodes - 2);
  const float t = x - static_cast<float>(i);
  const WavelengthSample& a = kWavelengths[i];
  const WavelengthSample& b = kWavelengths[i + 1];
  return {lerp(a.nm, b.nm, t), lerp(a.weight, b.weight, t)};
}

} // namespace kindling
