// Prints wavelength_tables.cpp: the draw of a wavelength and its weight. Run when dispersion.h changes:
//   cmake --build BUILD --target kindling_generate_wavelength_table &&
//   BUILD/.../kindling_generate_wavelength_table > renderer/bsdf/wavelength_tables.cpp
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/dispersion.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

namespace {

using namespace kindling;
using Vec = std::array<double, 3>;

double lobe(double nm, double peak, double mean, double left, double right) {
  const double t = (nm - mean) * (nm < mean ? left : right);
  return peak * std::exp(-0.5 * t * t);
}

// The CIE 1931 observer: Wyman, Sloan and Shirley 2013, "Simple Analytic Approximations to the CIE XYZ Color Matching Functions",
// multi-lobe fit.
Vec observer(double nm) {
  return {lobe(nm, 0.362, 442.0, 0.0624, 0.0374) + lobe(nm, 1.056, 599.8, 0.0264, 0.0323) +
              lobe(nm, -0.065, 501.1, 0.0490, 0.0382),
          lobe(nm, 0.821, 568.8, 0.0213, 0.0247) + lobe(nm, 0.286, 530.9, 0.0613, 0.0322),
          lobe(nm, 1.217, 437.0, 0.0845, 0.0278) + lobe(nm, 0.681, 459.0, 0.0385, 0.0725)};
}

// Responses of linear Rec. 709 without their negative lobes.
Vec response(double nm) {
  const Vec c = observer(nm);
  const Vec rgb = {3.2404542 * c[0] - 1.5371385 * c[1] - 0.4985314 * c[2],
                   -0.9692660 * c[0] + 1.8760108 * c[1] + 0.0415560 * c[2],
                   0.0556434 * c[0] - 0.2040259 * c[1] + 1.0572252 * c[2]};
  return {std::max(rgb[0], 0.0), std::max(rgb[1], 0.0), std::max(rgb[2], 0.0)};
}

} // namespace

int main() {
  constexpr int kSteps = 31000;
  constexpr double kFirst = 680.0; // red end at u = 0
  constexpr double kLast = 390.0;
  constexpr std::array<double, 3> kShares = {0.30, 0.45, 0.25};
  Vec integral = {0.0, 0.0, 0.0};
  const auto nm_of_step = [&](double i) { return kFirst + (kLast - kFirst) * i / kSteps; };
  for (int i = 0; i < kSteps; ++i) {
    const Vec f = response(nm_of_step(i + 0.5));
    for (int c = 0; c < 3; ++c) integral[c] += f[c] / kSteps;
  }
  const auto density = [&](double nm) {
    const Vec f = response(nm);
    double sum = 0.0;
    for (int c = 0; c < 3; ++c) sum += kShares[c] * f[c] / integral[c];
    return sum;
  };
  // Inverse of the distribution at even u.
  std::vector<double> nodes = {kFirst};
  std::vector<Vec> weights;
  double before = 0.0;
  for (int i = 0; i < kSteps && nodes.size() < kWavelengthNodes - 1; ++i) {
    const double after = before + density(nm_of_step(i + 0.5)) / kSteps;
    while (nodes.size() < kWavelengthNodes - 1) {
      const double u = static_cast<double>(nodes.size()) / (kWavelengthNodes - 1);
      if (u > after) break;
      nodes.push_back(nm_of_step(i + (u - before) / (after - before)));
    }
    before = after;
  }
  nodes.push_back(kLast);
  Vec mean = {0.0, 0.0, 0.0};
  for (uint32_t i = 0; i < kWavelengthNodes; ++i) {
    const Vec f = response(nodes[i]);
    const double p = density(nodes[i]);
    Vec w;
    for (int c = 0; c < 3; ++c) {
      w[c] = f[c] / integral[c] / p;
      mean[c] += w[c] * (i == 0 || i == kWavelengthNodes - 1 ? 0.5 : 1.0) / (kWavelengthNodes - 1);
    }
    weights.push_back(w);
  }
  std::printf(
      "// Wavelengths and their weights: printed by generate_wavelength_table.cpp, read through dispersion.h. Do not "
      "edit.\n"
      "// SPDX-License-Identifier: Apache-2.0\n"
      "#include \"renderer/bsdf/dispersion.h\"\n\n"
      "namespace kindling {\n\n"
      "// clang-format off\n"
      "const WavelengthSample kWavelengths[kWavelengthNodes] = {\n");
  for (uint32_t i = 0; i < kWavelengthNodes; ++i) {
    // The trapezoids of what is read have a mean of exactly 1.
    std::printf("{%.3ff,{%.7ff,%.7ff,%.7ff}},%s", nodes[i], weights[i][0] / mean[0], weights[i][1] / mean[1],
                weights[i][2] / mean[2], i % 4 == 3 || i == kWavelengthNodes - 1 ? "\n" : " ");
  }
  std::printf("};\n// clang-format on\n\n} // namespace kindling\n");
}
