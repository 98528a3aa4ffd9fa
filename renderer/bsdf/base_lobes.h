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
// and a dielectric weight below 1 where the remainder transmits specularly.
class BaseLobes {
 public:
  // Parameters must be in their ranges; wo must be unit with wo.z >= kMinCosTheta.
  BaseLobes(const BsdfParameters& parameters, const LayerParameters& layers, const V3f& wo);

  template <typename Real>
  struct EvalOf {
    Imath::Vec3<Real> value{Real(0.0f)}; // f |cos_theta_i|
    Real glossy_pdf = 0.0f;              // of sample_glossy(), above the horizon
  };
  using Eval = EvalOf<float>;
  // wi must be unit with wi.z != 0; it may be above or below the horizon.
  [[nodiscard]] Eval eval(const V3f& wi) const { return wi.z > 0.0f ? eval_above(wi) : eval_below(wi); }
  // eval() of a direction above the horizon (float) or of several (Lanes); lanes of others have any
  // result.
  template <typename Real>
  [[nodiscard]] EvalOf<Real> eval_above(const Imath::Vec3<Real>& wi) const;
  // Returns the diffuse reflection's part of eval().value.
  [[nodiscard]] Rgb diffuse_value(const V3f& wi) const;
  [[nodiscard]] V3f sample_glossy(const V2f& u) const { return lobe_.sample(u); }

  // Returns the larger alpha of sample_glossy()'s microfacets; 0 for Lambert.
  [[nodiscard]] float alpha() const { return has_microfacets_ ? lobe_.max_alpha() : 0.0f; }

  // Directional albedos from wo: of single scattering (sampled by sample_glossy()), and of the
  // cosine lobes above and below the surface.
  [[nodiscard]] const Rgb& glossy_albedo() const { return glossy_albedo_; }
  [[nodiscard]] const Rgb& cosine_albedo() const { return cosine_albedo_; }
  [[nodiscard]] const Rgb& transmitted_albedo() const { return transmitted_albedo_; }
  // Returns the part of cosine_albedo() that is diffuse reflection; the rest is multiple scattering
  // between microfacets.
  [[nodiscard]] const Rgb& diffuse_albedo() const { return diffuse_albedo_; }

 private:
  [[nodiscard]] Eval eval_below(const V3f& wi) const;
  [[nodiscard]] GgxAlbedo microfacet_albedo(const V3f& w) const {
    return anisotropic_ ? anisotropic_table_(w) : table_(std::abs(w.z));
  }
  [[nodiscard]] GgxAlbedoOf<Lanes> microfacet_albedo(const Imath::Vec3<Lanes>& w) const;
  // The middle azimuth represents all of them.
  [[nodiscard]] GgxAlbedo middle_albedo(float mu) const {
    const float xy = std::sqrt(0.5f * (1.0f - mu * mu));
    return microfacet_albedo(V3f(xy, xy, mu));
  }
  // Returns the fraction of light that the dielectric's specular layer lets in (or out), 1 - S.
  template <typename Real>
  [[nodiscard]] Real through(const GgxAlbedoOf<Real>& seen, const std::type_identity_t<Real>& mu) const {
    Real s = base_constant_ + base_e_ * seen.e + base_b_ * seen.b;
    if (film_dielectric_ > 0.0f)
      s = s - film_amount_ * specular_ * (film_schlick_ * seen.b + seen.e * film_residual_at(mu));
    return maximum(s, Real(0.0f));
  }
  [[nodiscard]] float film_residual_at(float mu) const {
    const FilmAlbedo::Position at = FilmAlbedo::position(mu);
    return lerp(film_residual_[at.node], film_residual_[at.node + 1], at.fraction);
  }
  [[nodiscard]] Lanes film_residual_at(const Lanes& mu) const {
    return for_each_lane([this](float one) { return film_residual_at(one); }, mu);
  }
  // The plain material, for set_film().
  struct FilmBase {
    Rgb dielectric_f0, metal_f0; // with specular color, without the weight of the specular
    Rgb fresnel_f0;              // of the dielectric, with that weight
    float dielectric, metal, roughness, roughness_x;
    GgxAlbedo seen, mean; // from wo, and over the hemisphere
  };
  struct FilmMeans {
    Rgb dielectric_f0, metal_f0; // for which Schlick's mean Fresnel is the film's
    float reflected;             // cosine-weighted mean of the film's part of S
  };
  FilmMeans set_film(const FilmBase& base, const LayerParameters& layers, float mu);
  float set_film_residual(const FilmBase& base, const FilmAlbedo& film, const Rgb& mean_f0);

  GgxLobe lobe_;
  bool has_microfacets_ = false; // else Lambert: only diffuse_ and transmitted_ are set below
  bool anisotropic_ = false;
  Rgb glossy_albedo_{0.0f};
  Rgb cosine_albedo_{0.0f};
  Rgb transmitted_albedo_{0.0f};
  Rgb diffuse_albedo_{0.0f};
  Rgb diffuse_{0.0f};     // the diffuse lobe without the factor (1 - S(i))
  Rgb transmitted_{0.0f}; // diffuse transmission without the factor (1 - S(i))
  Rgb multiple_{0.0f};    // the multiple-scattering lobe without the factor (1 - E(i))
  Rgb f0_{0.0f};
  float f90_ = 0.0f;
  // 1 - S = base_constant_ + base_e_ E + base_b_ B, minus the reflection of a film
  float base_constant_ = 1.0f;
  float base_e_ = 0.0f;
  float base_b_ = 0.0f;
  GgxAlbedoTable table_{1.0f, 1.0f};
  AnisotropicAlbedoTable anisotropic_table_{1.0f, 1.0f};

  float film_amount_ = 0.0f; // [0, 1], 0: no film
  std::optional<FilmLayer> film_on_dielectric_, film_on_metal_;
  float film_dielectric_ = 0.0f, film_metal_ = 0.0f; // weights
  float film_schlick_ = 1.0f;                        // FilmAlbedo::schlick_share()
  std::array<float, kFilmNodes> film_residual_;      // FilmAlbedo::residual(), of the brightest channel
  float specular_ = 0.0f;
};

} // namespace kindling
