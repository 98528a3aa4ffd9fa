// Quadrature over the microfacets that a view sees; for the generators of tables.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kindling {

// The view of an isotropic GGX surface. mu: cosine of the view, above 0; alpha: squared roughness.
struct GgxView {
  double mu;
  double alpha;

  // Returns sqrt(alpha^2 sin^2 + cos^2) of a direction with this cosine.
  [[nodiscard]] double stretched(double cosine) const {
    return std::sqrt(alpha * alpha + (1.0 - alpha * alpha) * cosine * cosine);
  }
  // Returns G2 / G1 towards a direction with this cosine; 0 below the surface.
  [[nodiscard]] double shadowing(double mu_i) const {
    if (mu_i <= 0.0) return 0.0;
    const double t_o = stretched(mu);
    return mu_i * (mu + t_o) / (mu_i * t_o + mu * stretched(mu_i));
  }
};

// Calls f(cos_o, normal_z) for rows * columns visible normals of equal probability: the cosines of
// the normal with the view and with the surface's normal. Midpoint rule over a spherical cap (Dupuy
// and Benyoub 2023), half of its circle, since the other half is its mirror image. Rows are shifted
// against each other, so that edges do not fall between the same samples of all rows.
template <typename F>
void for_each_visible_normal(const GgxView& view, int rows, int columns, const F& f) {
  const double sin_o = std::sqrt(1.0 - view.mu * view.mu);
  const double t_o = view.stretched(view.mu);
  const double cap_x = view.alpha * sin_o / t_o;
  const double cap_z = view.mu / t_o;
  for (int i = 0; i < rows; ++i) {
    const double z = 1.0 - (i + 0.5) / rows * (1.0 + cap_z);
    const double sin_z = std::sqrt(std::max(0.0, 1.0 - z * z));
    const double shift = std::fmod(i * std::numbers::phi, 1.0);
    for (int j = 0; j < columns; ++j) {
      const double phi = std::numbers::pi * (j + shift) / columns;
      const double x = view.alpha * (sin_z * std::cos(phi) + cap_x);
      const double y = view.alpha * sin_z * std::sin(phi);
      const double w = z + cap_z;
      const double scale = 1.0 / std::sqrt(x * x + y * y + w * w);
      f((sin_o * x + view.mu * w) * scale, w * scale);
    }
  }
}

} // namespace kindling
