// Generator of anisotropic_tables.cpp: albedos of the anisotropic GGX lobe by quadrature.
// Run it after changes of the parametrization in anisotropic_albedo.h:
//   cmake --build BUILD --target kindling_generate_anisotropic_tables &&
//   BUILD/.../kindling_generate_anisotropic_tables > renderer/bsdf/anisotropic_tables.cpp
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/anisotropic_albedo.h"

#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

// Empty tables satisfy the declarations that are default arguments of the lookups.
namespace kindling {
const AnisotropicTableNode kAnisotropicTable[kAnisotropicNodes * kAnisotropicNodes * kAnisotropicNodes] = {};
const GgxAlbedo kAnisotropicAverages[kAnisotropicAverageNodes * kAnisotropicAverageNodes] = {};
} // namespace kindling

namespace {

using namespace kindling;

struct Albedo {
  double e = 0.0;
  double b = 0.0;
};

// Midpoint rule over the visible normals (spherical caps, Dupuy and Benyoub 2023); the remaining
// integrand is G2 / G1 in [0, 1]. The view is at (x, y, mu); rows are shifted against each other.
Albedo integrate(double x, double y, double mu, double alpha_x, double alpha_y) {
  constexpr int kRows = 400;
  constexpr int kColumns = 400;
  const auto stretched = [&](double u, double v, double w) { return std::hypot(alpha_x * u, alpha_y * v, w); };
  const double t_o = stretched(x, y, mu);
  const double cap_x = alpha_x * x / t_o;
  const double cap_y = alpha_y * y / t_o;
  const double cap_z = mu / t_o;
  Albedo sum;
  for (int i = 0; i < kRows; ++i) {
    const double z = 1.0 - (i + 0.5) / kRows * (1.0 + cap_z);
    const double sin_z = std::sqrt(std::max(0.0, 1.0 - z * z));
    const double shift = std::fmod(i * std::numbers::phi, 1.0);
    for (int j = 0; j < kColumns; ++j) {
      const double phi = 2.0 * std::numbers::pi * (j + shift) / kColumns;
      const double hx = alpha_x * (sin_z * std::cos(phi) + cap_x);
      const double hy = alpha_y * (sin_z * std::sin(phi) + cap_y);
      const double hz = z + cap_z;
      const double length2 = hx * hx + hy * hy + hz * hz;
      const double scale = 2.0 * (x * hx + y * hy + mu * hz) / length2;
      const double mu_i = scale * hz - mu;
      if (mu_i <= 0.0) continue;
      const double t_i = stretched(scale * hx - x, scale * hy - y, mu_i);
      const double weight = mu_i * (mu + t_o) / (mu_i * t_o + mu * t_i);
      const double q = std::max(1.0 - 0.5 * scale * std::sqrt(length2), 0.0);
      sum.e += weight;
      sum.b += weight * q * q * q * q * q;
    }
  }
  return {sum.e / (kRows * kColumns), sum.b / (kRows * kColumns)};
}

double node_roughness(uint32_t i, uint32_t count) { return kMinRoughness + (1.0 - kMinRoughness) * i / (count - 1.0); }

std::vector<AnisotropicTableNode> make_table() {
  std::vector<AnisotropicTableNode> table;
  for (uint32_t i = 0; i < kAnisotropicNodes; ++i) {
    const double across = std::pow(node_roughness(i, kAnisotropicNodes), 2.0);
    for (uint32_t j = 0; j < kAnisotropicNodes; ++j) {
      const double along = std::pow(node_roughness(j, kAnisotropicNodes), 2.0);
      for (uint32_t k = 0; k < kAnisotropicNodes; ++k) {
        const double c = k / (kAnisotropicNodes - 1.0);
        const double mu = std::min(2.0 * along * c * c / (1.0 + 2.0 * along - c * c), 1.0);
        const double r = std::sqrt(1.0 - mu * mu);
        const double schlick = std::pow(1.0 - mu, 5.0);
        const Albedo a = integrate(r, 0.0, mu, along, across);
        // Full correlation: all of the roughness is along x, and the plane of incidence is oblique
        // to it.
        const double length = std::hypot(along, across);
        const Albedo b = integrate(r * along / length, r * across / length, mu, length, 1e-4 * length);
        const double residual = a.b / a.e - schlick;
        table.push_back({static_cast<float>(a.e), static_cast<float>(residual), static_cast<float>(b.e - a.e),
                         static_cast<float>(b.b / b.e - schlick - residual)});
      }
    }
  }
  return table;
}

GgxAlbedo average(const std::vector<AnisotropicTableNode>& nodes, double roughness_x, double roughness_y) {
  constexpr int kSteps = 400;
  constexpr int kAzimuths = 64; // of a quarter of the circle
  const AnisotropicAlbedoTable table(static_cast<float>(roughness_x * roughness_x),
                                     static_cast<float>(roughness_y * roughness_y), nodes.data());
  Albedo sum;
  for (int i = 0; i < kSteps; ++i) {
    const double root = (i + 0.5) / kSteps; // mu = root^2: finer where E dips
    const double mu = root * root;
    const double r = std::sqrt(1.0 - mu * mu);
    const double weight = 4.0 * root * root * root / (kSteps * kAzimuths);
    for (int j = 0; j < kAzimuths; ++j) {
      // Steps shrink towards both axes, since lobes are narrow along a smooth direction.
      const double u = (j + 0.5) / kAzimuths;
      const double phi = 0.5 * std::numbers::pi * u * u * (3.0 - 2.0 * u);
      const GgxAlbedo a = table(
          V3f(static_cast<float>(r * std::cos(phi)), static_cast<float>(r * std::sin(phi)), static_cast<float>(mu)));
      const double w = weight * 6.0 * u * (1.0 - u);
      sum.e += w * static_cast<double>(a.e);
      sum.b += w * static_cast<double>(a.b);
    }
  }
  return {static_cast<float>(sum.e), static_cast<float>(sum.b)};
}

} // namespace

int main() {
  const std::vector<AnisotropicTableNode> table = make_table();
  std::printf(
      "// Albedo of the anisotropic GGX lobe, generated by generate_anisotropic_tables.cpp. Do not edit.\n"
      "// SPDX-License-Identifier: Apache-2.0\n"
      "#include \"renderer/bsdf/anisotropic_albedo.h\"\n\n"
      "namespace kindling {\n\n"
      "// clang-format off\n"
      "// E, Schlick residual, and what full correlation adds to both.\n"
      "// Rows in mu, for roughness across and along the plane of incidence.\n"
      "const AnisotropicTableNode kAnisotropicTable[kAnisotropicNodes * kAnisotropicNodes * kAnisotropicNodes] = {\n");
  for (size_t i = 0; i < table.size(); ++i) {
    const AnisotropicTableNode& n = table[i];
    std::printf("{%.5ff,%.5ff,%.4ff,%.4ff},%s", static_cast<double>(n.e), static_cast<double>(n.residual),
                static_cast<double>(n.e_correlated), static_cast<double>(n.residual_correlated),
                i % 4 == 3 ? "\n" : " ");
  }
  std::printf("};\n\n// Means of E and B over the hemisphere: rows in roughness along x, for roughness along y.\n"
              "const GgxAlbedo kAnisotropicAverages[kAnisotropicAverageNodes * kAnisotropicAverageNodes] = {\n");
  for (uint32_t i = 0; i < kAnisotropicAverageNodes; ++i) {
    for (uint32_t j = 0; j < kAnisotropicAverageNodes; ++j) {
      const GgxAlbedo a =
          average(table, node_roughness(j, kAnisotropicAverageNodes), node_roughness(i, kAnisotropicAverageNodes));
      std::printf("{%.6ff,%.6ff},%s", static_cast<double>(a.e), static_cast<double>(a.b), j % 6 == 5 ? "\n" : " ");
    }
  }
  std::printf("};\n// clang-format on\n\n} // namespace kindling\n");
}
