// Prints dielectric_tables.cpp: what a rough interface reflects and transmits, by quadrature. Run when the parametrization in
// dielectric_albedo.h changes (a minute):
//   cmake --build BUILD --target kindling_generate_dielectric_tables &&
//   BUILD/.../kindling_generate_dielectric_tables > renderer/bsdf/dielectric_tables.cpp
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/dielectric_albedo.h"

#include <cmath>
#include <cstdio>
#include <numbers>

namespace {

using namespace kindling;

double exact_fresnel(double cos_i, double cos_t, double eta) {
  const double parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  const double perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  return 0.5 * (parallel * parallel + perpendicular * perpendicular);
}

struct Albedo {
  double e = 0.0, p = 0.0, q = 0.0, reflected = 0.0;
};

// Midpoint rule over the visible normals (spherical caps, Dupuy and Benyoub 2023), where what is left to integrate is Fresnel times
// G2 / G1 in [0, 1]. Rows are shifted against each other, so that edges do not fall between the same samples of all.
Albedo integrate(double mu, double alpha, double eta) {
  constexpr int kRows = 320;
  constexpr int kColumns = 320; // half of the circle: the other half is its mirror image
  const double a2 = alpha * alpha;
  const double sin_o = std::sqrt(1.0 - mu * mu);
  const double t_o = std::sqrt(a2 + (1.0 - a2) * mu * mu);
  const double cap_x = alpha * sin_o / t_o;
  const double cap_z = mu / t_o;
  const auto shadowing = [&](double mu_i) {
    if (mu_i <= 0.0) return 0.0;
    return mu_i * (mu + t_o) / (mu_i * t_o + mu * std::sqrt(a2 + (1.0 - a2) * mu_i * mu_i));
  };
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
      const double normal_z = w * scale;
      const double cos_o = (sin_o * x + mu * w) * scale;
      const double reflection = shadowing(2.0 * cos_o * normal_z - mu);
      const double cos2_t = 1.0 - (1.0 - cos_o * cos_o) / (eta * eta);
      if (cos2_t <= 0.0) {
        sum.e += reflection;
        sum.reflected += reflection;
        continue;
      }
      const double cos_t = std::sqrt(cos2_t);
      const double f = exact_fresnel(cos_o, cos_t, eta);
      const double refraction = shadowing(mu / eta - normal_z * (cos_o / eta - cos_t));
      sum.e += f * reflection + (1.0 - f) * refraction;
      sum.p += reflection - refraction;
      sum.q += f * (reflection - refraction);
      sum.reflected += f * reflection;
    }
  }
  constexpr double kScale = 1.0 / (static_cast<double>(kRows) * kColumns);
  return {sum.e * kScale, sum.p * kScale, sum.q * kScale, sum.reflected / sum.e};
}

int16_t signed_value(double x) { return static_cast<int16_t>(std::lround(std::min(std::max(x, -1.0), 1.0) * 32767.0)); }

void print_table(const char* name, const char* shape_name, const DielectricTableShape& shape, bool outside) {
  std::printf("const DielectricTableNode %s[%s.mu * %s.roughness * %s.eta] = {\n", name, shape_name, shape_name,
              shape_name);
  constexpr double kFirst = static_cast<double>(kDielectricFirstCosine);
  constexpr double kLast = static_cast<double>(kDielectricLastCosine);
  constexpr double kSmooth = static_cast<double>(kStraightRoughness);
  for (uint32_t k = 0; k < shape.eta; ++k) {
    const double critical = kFirst + (kLast - kFirst) * k / (shape.eta - 1.0);
    const double smaller = std::sqrt(1.0 - critical * critical);
    const double eta = outside ? 1.0 / smaller : smaller;
    for (uint32_t j = 0; j < shape.roughness; ++j) {
      const double roughness = kSmooth + (1.0 - kSmooth) * j / (shape.roughness - 1.0);
      const double alpha = roughness * roughness;
      for (uint32_t i = 0; i < shape.mu; ++i) {
        const double x = i / (shape.mu - 1.0);
        const double mu = std::min(std::max(2.0 * alpha * x * x / (1.0 + 2.0 * alpha - x * x), 1e-6), 1.0);
        const Albedo a = integrate(mu, alpha, eta);
        const auto guess = static_cast<double>(
            guessed_reflectance(static_cast<float>(mu), static_cast<float>(alpha), static_cast<float>(eta)));
        std::printf("{%d,%d,%d,%d},%s", static_cast<int>(std::lround(a.e * 65535.0)), signed_value(a.p),
                    signed_value(a.q), signed_value(a.reflected - guess), i + 1 == shape.mu ? "\n" : "");
      }
    }
  }
  std::printf("};\n");
}

} // namespace

int main() {
  std::printf("// Albedos of rough dielectric interfaces: printed by generate_dielectric_tables.cpp, read through "
              "dielectric_albedo.h. Do not edit.\n"
              "// SPDX-License-Identifier: Apache-2.0\n"
              "#include \"renderer/bsdf/dielectric_albedo.h\"\n\n"
              "namespace kindling {\n\n"
              "// clang-format off\n");
  print_table("kDielectricTableOutside", "kDielectricOutside", kDielectricOutside, true);
  print_table("kDielectricTableInside", "kDielectricInside", kDielectricInside, false);
  std::printf("// clang-format on\n\n} // namespace kindling\n");
}
