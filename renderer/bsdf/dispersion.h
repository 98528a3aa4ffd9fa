// Dispersion in linear Rec. 709: one wavelength per path that meets a dispersive material.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstdint>

namespace kindling {

// Returns the index of refraction at a wavelength in nm (> 0), by the first two terms of Cauchy's
// equation (KHR_materials_dispersion): n(lambda) = A + B / lambda^2 with ior at the d line (587.6
// nm) and Abbe number (n_d - 1) / (n_F - n_C) = 20 / dispersion. The result is at least 1.
// dispersion >= 0; 0 gives ior itself.
[[nodiscard]] float dispersed_ior(float ior, float dispersion, float nm);

struct WavelengthSample {
  float nm;   // wavelength that the path represents
  Rgb weight; // >= 0, factor of the path's contribution
};

// Samples a wavelength from a uniform u in [0, 1). Continuous in u; wavelengths decrease from 680
// nm at u = 0 to 390 nm. The mean weight over u is (1, 1, 1), up to the rounding of floats, so
// paths that do not depend on the wavelength keep their mean color.
// Weights are the responses of Rec. 709's primaries to a wavelength without their negative lobes
// (spectral colors are outside of the gamut), divided by the density of the draw, 0.30 r + 0.45 g +
// 0.25 b: at most 4 in any channel. The README states their variance.
[[nodiscard]] WavelengthSample sample_wavelength(float u);

inline constexpr uint32_t kWavelengthNodes = 129; // evenly spaced in u, both ends included

// Defined in wavelength_tables.cpp, written by generate_wavelength_table.cpp. Linear between nodes.
extern const WavelengthSample kWavelengths[kWavelengthNodes];

} // namespace kindling
