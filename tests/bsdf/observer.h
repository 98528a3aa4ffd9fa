// Colors of spectra in double precision: the CIE 1931 observer and Rec. 709.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace kindling::test {

using Vec = std::array<double, 3>;

inline double observer_lobe(double nm, double peak, double mean, double left, double right) {
  const double t = (nm - mean) * (nm < mean ? left : right);
  return peak * std::exp(-0.5 * t * t);
}

// CIE 1931 by Wyman, Sloan and Shirley 2013.
inline Vec observer(double nm) {
  return {observer_lobe(nm, 0.362, 442.0, 0.0624, 0.0374) + observer_lobe(nm, 1.056, 599.8, 0.0264, 0.0323) +
              observer_lobe(nm, -0.065, 501.1, 0.0490, 0.0382),
          observer_lobe(nm, 0.821, 568.8, 0.0213, 0.0247) + observer_lobe(nm, 0.286, 530.9, 0.0613, 0.0322),
          observer_lobe(nm, 1.217, 437.0, 0.0845, 0.0278) + observer_lobe(nm, 0.681, 459.0, 0.0385, 0.0725)};
}

inline Vec to_rec709(const Vec& c) {
  return {3.2404542 * c[0] - 1.5371385 * c[1] - 0.4985314 * c[2],
          -0.9692660 * c[0] + 1.8760108 * c[1] + 0.0415560 * c[2],
          0.0556434 * c[0] - 0.2040259 * c[1] + 1.0572252 * c[2]};
}

// Returns the linear Rec. 709 color of a spectrum, a function of the wavelength in nm, under the
// equal-energy illuminant; X, Y and Z of a flat spectrum of 1 are 1.
template <class Spectrum>
Vec integrate_spectrum(const Spectrum& spectrum) {
  Vec sum = {}, white = {};
  for (double nm = 360.5; nm < 830.0; nm += 1.0) {
    const Vec o = observer(nm);
    for (size_t c = 0; c < 3; ++c) {
      sum[c] += o[c] * spectrum(nm);
      white[c] += o[c];
    }
  }
  return to_rec709({sum[0] / white[0], sum[1] / white[1], sum[2] / white[2]});
}

} // namespace kindling::test
