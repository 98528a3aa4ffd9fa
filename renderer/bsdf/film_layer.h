// A thin film on an opaque base: its Fresnel term, and the mean of it over a rough surface.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/bsdf/fresnel.h"
#include "renderer/bsdf/ggx_albedo.h"
#include "renderer/bsdf/layer_parameters.h"
#include "renderer/bsdf/thin_film.h"

#include <array>

namespace kindling {

// The film of KHR_materials_iridescence. Under a clear coat it is lit from an ior of 1.5, by
// refracted light, in proportion to the coat. Cosines are with the microfacet, in air.
class FilmLayer {
 public:
  FilmLayer(const LayerParameters& layers, const Rgb& base_f0);

  // For one cosine (float), or for several (Lanes).
  template <typename Real>
  [[nodiscard]] Imath::Vec3<Real> fresnel(const Real& cos_theta) const {
    return film_.fresnel(cosine_below_coat(cos_theta));
  }
  // Returns the film's Fresnel at an angle that represents a lobe: B / E is the mean of (1 - cos)^5
  // over the lobe.
  [[nodiscard]] Rgb fresnel(const GgxAlbedo& seen) const;
  // Returns the F0 with which Schlick's Fresnel equals the film's at that angle.
  [[nodiscard]] Rgb f0(const GgxAlbedo& seen) const;
  // Returns the cosine within the coat; the same without one.
  template <typename Real>
  [[nodiscard]] Real cosine_below_coat(const Real& cos_theta) const {
    return outside_ior_ > 1.0f ? refracted_cosine(minimum(cos_theta, Real(1.0f)), outside_ior_) : cos_theta;
  }

 private:
  // Returns (1 - cos)^5 below the coat at that angle.
  [[nodiscard]] float schlick(const GgxAlbedo& seen) const;

  ThinFilm film_;
  float outside_ior_;
};

inline constexpr uint32_t kFilmNodes = 16; // of cosines
inline constexpr uint32_t kFilmRoughnessNodes = 12;

// Returns the cosine of a node, t (1 + t) / 2 with even steps of t in [0, 1]: closer towards
// grazing angles, where reflectance is steep.
[[nodiscard]] inline float film_node_cosine(uint32_t k) {
  const float t = static_cast<float>(k) * (1.0f / (kFilmNodes - 1));
  return 0.5f * t * (1.0f + t);
}
// Returns the weight of a node in cosine-weighted means over the hemisphere (trapezoidal rule in
// t), up to a factor.
[[nodiscard]] inline float film_node_area(uint32_t k) {
  const float t = static_cast<float>(k) * (1.0f / (kFilmNodes - 1));
  return film_node_cosine(k) * (0.5f + t) * (k == kFilmNodes - 1 ? 0.5f : 1.0f);
}

// Weights of the cosines of visible microfacets with wo, so that the sum of weights times values at
// the nodes is the mean over the lobe of the values interpolated linearly; 65535 is 1. By
// roughness, cosine with the facet, cosine of the view (the fastest). Roughness is evenly spaced
// from kMinRoughness to 1. Defined in film_tables.cpp, written by generate_film_tables.cpp.
extern const uint16_t kFilmTable[kFilmRoughnessNodes * kFilmNodes * kFilmNodes];

// The mean reflectance of a film over the microfacets seen under mu is schlick_share() B / E +
// residual: the steep rise to 1 at grazing angles, which B holds exactly, and a remainder. For
// films of up to 1000 nm the error of the mean is at most 0.08, 0.005 in the root mean square, and
// its mean over the views of a sphere below 0.005 (tests/bsdf/film_layer_test.cpp).
class FilmAlbedo {
 public:
  // roughness in [kMinRoughness, 1], isotropic.
  FilmAlbedo(const FilmLayer& film, float roughness);

  // The remainder at mu = film_node_cosine(k).
  [[nodiscard]] Rgb residual(uint32_t k) const { return {residual_[0][k], residual_[1][k], residual_[2][k]}; }
  [[nodiscard]] Rgb residual(float mu) const;
  [[nodiscard]] float schlick_share() const { return schlick_share_; }
  // Returns the cosine-weighted mean of the smooth film's Fresnel over the hemisphere.
  [[nodiscard]] const Rgb& mean_fresnel() const { return mean_fresnel_; }

  // Position of mu among the nodes.
  struct Position {
    uint32_t node;
    float fraction;
  };
  [[nodiscard]] static Position position(float mu) {
    const float t = 0.5f * (std::sqrt(1.0f + 8.0f * std::min(mu, 1.0f)) - 1.0f);
    const float x = t * (kFilmNodes - 1);
    const auto node = cell_of(x, kFilmNodes - 2);
    const float below = film_node_cosine(node);
    return {node, (std::min(mu, 1.0f) - below) / (film_node_cosine(node + 1) - below)};
  }

 private:
  using Nodes = std::array<float, kFilmNodes>;
  std::array<Nodes, 3> residual_; // of red, green and blue
  float schlick_share_ = 1.0f;
  Rgb mean_fresnel_{0.0f};
};

} // namespace kindling
