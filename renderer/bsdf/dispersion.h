// Dispersion for a renderer that carries linear Rec. 709: one wavelength per path that meets a dispersive material.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstdint>

namespace kindling {

// Index of refraction of a material at a wavelength in nm (> 0), by the first two terms of Cauchy's equation
// (KHR_materials_dispersion): n(lambda) = A + B / lambda^2 with ior at the d line (587.6 nm) and Abbe number
// (n_d - 1) / (n_F - n_C) = 20 / dispersion. At least 1. dispersion >= 0, 0: ior itself.
[[nodiscard]] float dispersed_ior(float ior, float dispersion, float nm);

struct WavelengthSample {
  float nm;   // of the light that the path stands for
  Rgb weight; // >= 0: what the path's contribution is multiplied with
};

// u in [0, 1), uniform. Continuous in u; wavelengths fall from 680 nm at u = 0 to 390 nm. The mean of the weight over u is
// (1, 1, 1), up to the rounding of floats: a path on which the wavelength plays no role keeps its color in the mean. Weights are
// the responses of Rec. 709's primaries to a wavelength, without their negative lobes (a color of the spectrum is more saturated
// than any the primaries mix), over the density 0.30 r + 0.45 g + 0.25 b of the draw: at most 4 in any channel. Their variance
// is stated in the README.
[[nodiscard]] WavelengthSample sample_wavelength(float u);

inline constexpr uint32_t kWavelengthNodes = 129; // even in u, both ends included

// wavelength_tables.cpp, written by generate_wavelength_table.cpp: linear in between.
extern const WavelengthSample kWavelengths[kWavelengthNodes];

} // namespace kindling
