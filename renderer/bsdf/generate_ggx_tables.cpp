// Prints ggx_tables.cpp: the albedo of the GGX lobe by quadrature. Run when the parametrization in ggx_albedo.h
// changes:
//   cmake --build BUILD --target kindling_generate_ggx_tables && BUILD/.../kindling_generate_ggx_tables >
//   renderer/bsdf/ggx_tables.cpp
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/ggx_albedo.h"

#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

// The tool fills its own tables; these satisfy the declarations that the lookup's defaults name.
namespace kindling {
const GgxTableNode kGgxTable[kGgxRoughnessNodes * kGgxMuNodes] = {};
const GgxAlbedo kGgxAverages[kGgxAverageNodes] = {};
} // namespace kindling

namespace {

using namespace kindling;

struct Albedo {
  double e = 0.0;
  double b = 0.0;
};

// Midpoint rule over the visible normals (spherical caps, Dupuy and Benyoub 2023), where what is left to integrate is
// G2 / G1 in [0, 1]. Rows are shifted against each other, so that the horizon does not fall between the same samples of
// all.
Albedo integrate(double mu, double alpha) {
  constexpr int kRows = 1024;
  constexpr int kColumns = 512; // half of the circle: the other half is its mirror image
  const double sin_o = std::sqrt(1.0 - mu * mu);
  const double t_o = std::sqrt(alpha * alpha + (1.0 - alpha * alpha) * mu * mu);
  const double cap_x = alpha * sin_o / t_o;
  const double cap_z = mu / t_o;
  Albedo sum;
  for (int i = 0; i < kRows; ++i) {
    const double z = 1.0 - (i + 0.5) / kRows * (1.0 + cap_z);
    const double sin_z = std::sqrt(std::max(0.0, 1.0 - z * z));
    const double shift = std::fmod(i * std::numbers::phi, 1.0);
    for (int j = 0; j < kColumns; ++j) {
      const double phi = std::numbers::pi * (j + shift) / kColumns;
      const double x = alpha * (sin_z * std::cos(phi) + cap_x);
      const double y = alpha * sin_z * std::sin(phi);
      const double w = z + cap_z;
      const double scale = 1.0 / std::sqrt(x * x + y * y + w * w);
      const double cos_d = (sin_o * x + mu * w) * scale;
      const double mu_i = 2.0 * cos_d * w * scale - mu;
      if (mu_i <= 0.0) continue;
      const double t_i = std::sqrt(alpha * alpha + (1.0 - alpha * alpha) * mu_i * mu_i);
      const double weight = mu_i * (mu + t_o) / (mu_i * t_o + mu * t_i);
      const double q = 1.0 - cos_d;
      sum.e += weight;
      sum.b += weight * q * q * q * q * q;
    }
  }
  return {sum.e / (kRows * kColumns), sum.b / (kRows * kColumns)};
}

double node_roughness(uint32_t i, uint32_t count) { return kMinRoughness + (1.0 - kMinRoughness) * i / (count - 1.0); }

std::vector<GgxTableNode> make_table() {
  std::vector<GgxTableNode> table;
  for (uint32_t row = 0; row < kGgxRoughnessNodes; ++row) {
    const double roughness = node_roughness(row, kGgxRoughnessNodes);
    const double alpha = roughness * roughness;
    for (uint32_t column = 0; column < kGgxMuNodes; ++column) {
      const double x = column / (kGgxMuNodes - 1.0);
      const double mu = std::min(2.0 * alpha * x * x / (1.0 + 2.0 * alpha - x * x), 1.0);
      const Albedo albedo = integrate(mu, alpha);
      const double schlick = std::pow(1.0 - mu, 5.0);
      table.push_back({static_cast<float>(albedo.e), static_cast<float>(albedo.b / albedo.e - schlick)});
    }
  }
  return table;
}

GgxAlbedo average(const std::vector<GgxTableNode>& nodes, double roughness) {
  constexpr int kSteps = 200000;
  const GgxAlbedoTable table(static_cast<float>(roughness), static_cast<float>(roughness * roughness), nodes.data());
  Albedo sum;
  for (int i = 0; i < kSteps; ++i) {
    const double root = (i + 0.5) / kSteps; // mu = root^2: finer where E dips
    const GgxAlbedo a = table(static_cast<float>(root * root));
    const double weight = 4.0 * root * root * root / kSteps;
    sum.e += weight * static_cast<double>(a.e);
    sum.b += weight * static_cast<double>(a.b);
  }
  return {static_cast<float>(sum.e), static_cast<float>(sum.b)};
}

} // namespace

int main() {
  const std::vector<GgxTableNode> table = make_table();
  std::printf("// Albedo of the GGX lobe: printed by generate_ggx_tables.cpp, read through ggx_albedo.h. Do not edit.\n"
              "// SPDX-License-Identifier: Apache-2.0\n"
              "#include \"renderer/bsdf/ggx_albedo.h\"\n\n"
              "namespace kindling {\n\n"
              "// clang-format off\n"
              "// E and Schlick residual; rows of %u nodes in mu, for %u roughnesses.\n"
              "const GgxTableNode kGgxTable[kGgxRoughnessNodes * kGgxMuNodes] = {\n",
              kGgxMuNodes, kGgxRoughnessNodes);
  for (size_t i = 0; i < table.size(); ++i) {
    std::printf("{%.7ff,%.7ff},%s", static_cast<double>(table[i].e), static_cast<double>(table[i].schlick_residual),
                i % 4 == 3 ? "\n" : " ");
  }
  std::printf("};\n\n// Means of E and B over the hemisphere, for %u roughnesses.\n"
              "const GgxAlbedo kGgxAverages[kGgxAverageNodes] = {\n",
              kGgxAverageNodes);
  for (uint32_t i = 0; i < kGgxAverageNodes; ++i) {
    const GgxAlbedo a = average(table, node_roughness(i, kGgxAverageNodes));
    std::printf("{%.7ff,%.7ff},%s", static_cast<double>(a.e), static_cast<double>(a.b), i % 4 == 3 ? "\n" : " ");
  }
  std::printf("};\n// clang-format on\n\n} // namespace kindling\n");
}
