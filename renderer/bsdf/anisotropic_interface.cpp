// Quadrature over the visible normals of an anisotropic interface.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/anisotropic_interface.h"

#include "renderer/sampling/warp.h"

#include <array>
#include <cassert>
#include <cmath>

namespace kindling {

namespace {

// Multiples of eight beside Fibonacci numbers, for which the spiral is nearly a lattice.
constexpr size_t kOutsidePoints = 232;
constexpr size_t kInsidePoints = 376;

// Azimuths of a Fibonacci spiral: turns i times the golden ratio.
struct Spiral {
  std::array<float, kInsidePoints> cos, sin;
};
constexpr Spiral make_spiral() {
  Spiral spiral{};
  for (size_t i = 0; i < kInsidePoints; ++i) {
    const double turns = static_cast<double>(i) * std::numbers::phi;
    const SinCos azimuth = sincos_turns(static_cast<float>(turns - static_cast<double>(static_cast<int32_t>(turns))));
    spiral.cos[i] = azimuth.cos;
    spiral.sin[i] = azimuth.sin;
  }
  return spiral;
}
constexpr Spiral kSpiral = make_spiral();

// Sums are added up in eight lanes: the same order on every machine, however wide its vectors are.
constexpr size_t kLanes = 8;
using PartialSums = std::array<float, kLanes>;
static_assert(kOutsidePoints % kLanes == 0 && kInsidePoints % kLanes == 0);

template <size_t kSize>
void add_block(const std::array<float, kSize>& values, size_t count, PartialSums& lanes) {
  for (size_t i = 0; i < count; i += kLanes)
    for (size_t lane = 0; lane < kLanes; ++lane) lanes[lane] += values[i + lane];
}

float sum_of(const PartialSums& lanes) {
  return ((lanes[0] + lanes[1]) + (lanes[2] + lanes[3])) + ((lanes[4] + lanes[5]) + (lanes[6] + lanes[7]));
}

} // namespace

// Uniform points on a spherical cap in the space where the microfacets are a hemisphere are visible
// normals (Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps"). What
// remains of the integrand is G2 / G1 in [0, 1] times Fresnel, continuous everywhere.
InterfaceIntegrals anisotropic_interface(const V3f& wo, float alpha_x, float alpha_y, float eta) {
  assert(wo.z > 0.0f && alpha_x > 0.0f && alpha_y > 0.0f && eta > 0.0f);
  const float t_o = std::sqrt(square(alpha_x * wo.x) + square(alpha_y * wo.y) + wo.z * wo.z);
  const V3f cap = V3f(alpha_x * wo.x, alpha_y * wo.y, wo.z) * (1.0f / t_o);
  const float x2 = alpha_x * alpha_x;
  const float y2 = alpha_y * alpha_y;
  const float inverse = 1.0f / eta;
  const float inverse2 = inverse * inverse;
  const V3f bent = wo * inverse;
  const size_t points = eta >= 1.0f ? kOutsidePoints : kInsidePoints;
  const float step = (1.0f + cap.z) / static_cast<float>(points);
  // G2 / G1 for a direction of this height and stretched length squared.
  const auto shadowing = [&](float mu_i, float t2_i) {
    const float g = mu_i * (wo.z + t_o) / (mu_i * t_o + wo.z * std::sqrt(t2_i));
    return mu_i > 0.0f ? g : 0.0f;
  };

  // Blocks of points rather than eight at a time: compilers make vectors of whole loops.
  constexpr size_t kBlock = 8 * kLanes;
  using Values = std::array<float, kBlock>;
  Values total, reflected, reflected_f, transmitted, transmitted_f;
  std::array<PartialSums, 5> sums{};
  for (size_t first = 0; first < points; first += kBlock) {
    const size_t count = std::min(kBlock, points - first);
    for (size_t k = 0; k < count; ++k) {
      const size_t i = first + k;
      const float height = (static_cast<float>(static_cast<int32_t>(i)) + 0.5f) * step; // 1 - z on the cap
      const float radius = std::sqrt(std::max(height * (2.0f - height), 0.0f));
      const float x = alpha_x * (radius * kSpiral.cos[i] + cap.x);
      const float y = alpha_y * (radius * kSpiral.sin[i] + cap.y);
      const float z = std::max(1.0f - height + cap.z, 1e-9f);
      const float scale = 1.0f / std::sqrt(x * x + y * y + z * z);
      const float hx = x * scale;
      const float hy = y * scale;
      const float hz = z * scale;
      const float cos_o = std::max(wo.x * hx + wo.y * hy + wo.z * hz, 0.0f);

      const float rx = 2.0f * cos_o * hx - wo.x;
      const float ry = 2.0f * cos_o * hy - wo.y;
      const float rz = 2.0f * cos_o * hz - wo.z;
      const float reflection = shadowing(rz, x2 * rx * rx + y2 * ry * ry + rz * rz);

      const float cos2_t = 1.0f - (1.0f - cos_o * cos_o) * inverse2;
      const float cos_t = std::sqrt(std::max(cos2_t, 0.0f));
      const float along = cos_o * inverse - cos_t;
      const float tx = along * hx - bent.x;
      const float ty = along * hy - bent.y;
      const float tz = bent.z - along * hz; // below the surface
      const float refraction = shadowing(tz, x2 * tx * tx + y2 * ty * ty + tz * tz);
      const float parallel = (eta * cos_o - cos_t) / (eta * cos_o + cos_t);
      const float perpendicular = (cos_o - eta * cos_t) / (cos_o + eta * cos_t);
      const float f = 0.5f * (parallel * parallel + perpendicular * perpendicular);

      const bool through = cos2_t > 0.0f;
      total[k] = through ? 0.0f : reflection;
      reflected[k] = through ? reflection : 0.0f;
      reflected_f[k] = through ? f * reflection : 0.0f;
      transmitted[k] = through ? refraction : 0.0f;
      transmitted_f[k] = through ? f * refraction : 0.0f;
    }
    add_block(total, count, sums[0]);
    add_block(reflected, count, sums[1]);
    add_block(reflected_f, count, sums[2]);
    add_block(transmitted, count, sums[3]);
    add_block(transmitted_f, count, sums[4]);
  }
  const float weight = 1.0f / static_cast<float>(points);
  return {sum_of(sums[0]) * weight, sum_of(sums[1]) * weight, sum_of(sums[2]) * weight, sum_of(sums[3]) * weight,
          sum_of(sums[4]) * weight};
}

} // namespace kindling
