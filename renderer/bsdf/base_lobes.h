// The opaque base of a layered surface: metal and dielectric, diffuse reflection and transmission.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/bsdf/anisotropic_albedo.h"
#include "renderer/bsdf/film_layer.h"
#include "renderer/bsdf/ggx_albedo.h"
#include "renderer/bsdf/ggx_lobe.h"
#include "renderer/bsdf/gltf_bsdf.h"
#include "renderer/bsdf/layer_parameters.h"

#include <array>
#include <optional>
#include <type_traits>

namespace kindling {

// The lobes of GltfBsdf (same formulas), extended by anisotropy, iridescence, diffuse transmission,
// and a dielectric weight below 1 where the remainder transmits specularly. One base, or eight in
// lanes: these have no films, and either all of them are is_lambertian(), or none is.
template <typename Each>
class BaseLobesOf {
 public:
  using Vector = Imath::Vec3<Each>;

  // Parameters must be in their ranges; wo must be unit with wo.z >= kMinCosTheta.
  BaseLobesOf(const BsdfParametersOf<Each>& parameters, const LayerParametersOf<Each>& layers, const Vector& wo);

  template <typename Real>
  struct EvalOf {
    Imath::Vec3<Real> value{Real(0.0f)}; // f |cos_theta_i|
    Real glossy_pdf = 0.0f;              // of sample_glossy(), above the horizon
  };
  // Returns value and density in a direction that is unit with wi.z > 0 (Real: Each), or in several
  // (Lanes); lanes of others have any result.
  template <typename Real>
  [[nodiscard]] EvalOf<Real> eval_above(const Imath::Vec3<Real>& wi) const;
  // Returns the value in a direction with wi.z < 0.
  [[nodiscard]] Vector value_below(const Vector& wi) const;
  // Returns the diffuse reflection's part of the value; wi.z > 0.
  [[nodiscard]] Vector diffuse_value(const Vector& wi) const;
  [[nodiscard]] Vector sample_glossy(const Imath::Vec2<Each>& u) const { return lobe_.sample(u); }

  // Returns the larger alpha of sample_glossy()'s microfacets; 0 for Lambert.
  [[nodiscard]] Each alpha() const { return has_microfacets_ ? lobe_.max_alpha() : Each(0.0f); }

  // Directional albedos from wo: of single scattering (sampled by sample_glossy()), and of the
  // cosine lobes above and below the surface.
  [[nodiscard]] const Vector& glossy_albedo() const { return glossy_albedo_; }
  [[nodiscard]] const Vector& cosine_albedo() const { return cosine_albedo_; }
  [[nodiscard]] const Vector& transmitted_albedo() const { return transmitted_albedo_; }
  // Returns the part of cosine_albedo() that is diffuse reflection; the rest is multiple scattering
  // between microfacets.
  [[nodiscard]] const Vector& diffuse_albedo() const { return diffuse_albedo_; }

 private:
  static constexpr bool kMayHaveFilm = std::is_same_v<Each, float>;

  // Replaces the Fresnel of the microfacets by the film's, as far as there is one.
  template <typename Real>
  void add_film(const Real& cos_d, Imath::Vec3<Real>& fresnel) const;
  template <typename Real>
  [[nodiscard]] GgxAlbedoOf<Real> microfacet_albedo(const Imath::Vec3<Real>& w) const;
  // The same for the middle azimuth, which represents all of them.
  [[nodiscard]] GgxAlbedo middle_albedo(float mu) const {
    const float xy = std::sqrt(0.5f * (1.0f - mu * mu));
    return microfacet_albedo(V3f(xy, xy, mu));
  }
  // Returns the fraction of light that the dielectric's specular layer lets in (or out), 1 - S.
  template <typename Real>
  [[nodiscard]] Real through(const GgxAlbedoOf<Real>& seen, const std::type_identity_t<Real>& mu) const {
    Real s = base_constant_ + base_e_ * seen.e + base_b_ * seen.b;
    if constexpr (kMayHaveFilm) {
      if (film_.dielectric > 0.0f)
        s = s - film_.amount * film_.specular * (film_.schlick * seen.b + seen.e * film_residual_at(mu));
    }
    return maximum(s, Real(0.0f));
  }

  // A film on the base, for single bases.
  struct Film {
    float amount = 0.0f; // [0, 1], 0: no film
    std::optional<FilmLayer> on_dielectric, on_metal;
    float dielectric = 0.0f, metal = 0.0f;  // weights
    float specular = 0.0f;                  // that of the dielectric
    float schlick = 1.0f;                   // FilmAlbedo::schlick_share()
    std::array<float, kFilmNodes> residual; // FilmAlbedo::residual(), of the brightest channel
  };
  struct NoFilm {};
  // The plain material, for set_film().
  struct FilmBase {
    Rgb dielectric_f0, metal_f0; // with specular color, without the weight of the specular
    Rgb fresnel_f0;              // of the dielectric, with that weight
    float dielectric, metal, specular, roughness, roughness_x;
    GgxAlbedo seen, mean; // from wo, and over the hemisphere
  };
  struct FilmMeans {
    Vector dielectric_f0, metal_f0; // for which Schlick's mean Fresnel is the film's
    Each reflected = 0.0f;          // cosine-weighted mean of the film's part of S
  };
  [[nodiscard]] FilmMeans set_film(const FilmBase& base, const LayerParameters& layers, float mu);
  [[nodiscard]] float set_film_residual(const FilmBase& base, const FilmAlbedo& film, const Rgb& mean_f0);
  [[nodiscard]] float film_residual_at(float mu) const {
    const FilmAlbedo::Position at = FilmAlbedo::position(mu);
    return lerp(film_.residual[at.node], film_.residual[at.node + 1], at.fraction);
  }
  [[nodiscard]] Lanes film_residual_at(const Lanes& mu) const {
    return for_each_lane([this](float one) { return film_residual_at(one); }, mu);
  }

  GgxLobeOf<Each> lobe_;
  bool has_microfacets_ = false; // else Lambert: only diffuse_ and transmitted_ are set below
  MaskOf<Each> anisotropic_{};
  Vector glossy_albedo_{0.0f};
  Vector cosine_albedo_{0.0f};
  Vector transmitted_albedo_{0.0f};
  Vector diffuse_albedo_{0.0f};
  Vector diffuse_{0.0f};     // the diffuse lobe without the factor (1 - S(i))
  Vector transmitted_{0.0f}; // diffuse transmission without the factor (1 - S(i))
  Vector multiple_{0.0f};    // the multiple-scattering lobe without the factor (1 - E(i))
  Vector f0_{0.0f};
  Each f90_ = 0.0f;
  // 1 - S = base_constant_ + base_e_ E + base_b_ B, minus the reflection of a film
  Each base_constant_ = 1.0f;
  Each base_e_ = 0.0f;
  Each base_b_ = 0.0f;
  GgxAlbedoTableOf<Each> table_{1.0f, 1.0f};
  AnisotropicAlbedoTableOf<Each> anisotropic_table_{1.0f, 1.0f};
  std::conditional_t<kMayHaveFilm, Film, NoFilm> film_;
};
using BaseLobes = BaseLobesOf<float>;

template <>
BaseLobes::FilmMeans BaseLobes::set_film(const FilmBase& base, const LayerParameters& layers, float mu);
template <>
float BaseLobes::set_film_residual(const FilmBase& base, const FilmAlbedo& film, const Rgb& mean_f0);

} // namespace kindling
