// The opaque base of a layered surface: metal and dielectric, diffuse reflection and transmission.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/bsdf/anisotropic_albedo.h"
#include "renderer/bsdf/ggx_albedo.h"
#include "renderer/bsdf/ggx_lobe.h"
#include "renderer/bsdf/gltf_bsdf.h"
#include "renderer/bsdf/layer_parameters.h"

namespace kindling {

// A thin film on the base (KHR_materials_iridescence). Under a clear coat the film is lit from an
// ior of 1.5, by refracted light, in proportion to the coat.
struct FilmLayer {
  float amount = 0.0f; // [0, 1], 0: none
  float outside_ior = 1.0f;
  float ior = 1.3f;
  float thickness_nm = 0.0f;

  [[nodiscard]] Rgb fresnel(float cos_theta, const Rgb& base_f0) const;
  // Returns (1 - cos)^5 at an angle that represents a lobe: B / E is the mean of (1 - cos)^5 over
  // the lobe. It interpolates the film's Fresnel towards grazing angles as Schlick's does.
  [[nodiscard]] float schlick(const GgxAlbedo& seen) const;
  // Returns the film's Fresnel at that angle.
  [[nodiscard]] Rgb fresnel(const GgxAlbedo& seen, const Rgb& base_f0) const;
  // Returns the F0 with which Schlick's Fresnel equals the film's at that angle: a smooth function
  // of the cosine, except for interference.
  [[nodiscard]] Rgb f0(const GgxAlbedo& seen, const Rgb& base_f0) const;
};

// The lobes of GltfBsdf (same formulas), extended by anisotropy, iridescence, diffuse transmission,
// and a dielectric weight below 1 where the remainder transmits specularly.
class BaseLobes {
 public:
  // Parameters must be in their ranges; wo must be unit with wo.z >= kMinCosTheta.
  BaseLobes(const BsdfParameters& parameters, const LayerParameters& layers, const V3f& wo);

  struct Eval {
    Rgb value{0.0f};        // f |cos_theta_i|
    float glossy_pdf{0.0f}; // of sample_glossy(), above the horizon
  };
  // wi must be unit with wi.z != 0; it may be above or below the horizon.
  [[nodiscard]] Eval eval(const V3f& wi) const;
  [[nodiscard]] V3f sample_glossy(const V2f& u) const { return lobe_.sample(u); }

  // Directional albedos from wo: of single scattering (sampled by sample_glossy()), and of the
  // cosine lobes above and below the surface.
  [[nodiscard]] const Rgb& glossy_albedo() const { return glossy_albedo_; }
  [[nodiscard]] const Rgb& cosine_albedo() const { return cosine_albedo_; }
  [[nodiscard]] const Rgb& transmitted_albedo() const { return transmitted_albedo_; }

 private:
  static constexpr int kFilmNodes = 8; // evenly spaced in mu

  [[nodiscard]] GgxAlbedo microfacet_albedo(const V3f& w) const {
    return anisotropic_ ? anisotropic_table_(w) : table_(std::abs(w.z));
  }
  // Returns the fraction of light that the dielectric's specular layer lets in (or out), 1 - S.
  [[nodiscard]] float through(const GgxAlbedo& seen, float mu) const {
    float s = base_constant_ + base_e_ * seen.e + base_b_ * seen.b;
    if (film_dielectric_ > 0.0f) {
      const float x = film_.schlick(seen);
      s -= film_.amount * specular_ * seen.e * (x + (1.0f - x) * film_f0_at(mu));
    }
    return std::max(s, 0.0f);
  }
  [[nodiscard]] float film_f0_at(float mu) const {
    const float x = std::min(mu, 1.0f) * (kFilmNodes - 1);
    const int i = std::min(static_cast<int>(x), kFilmNodes - 2);
    return lerp(film_f0_[i], film_f0_[i + 1], x - static_cast<float>(i));
  }

  GgxLobe lobe_;
  bool has_microfacets_ = false; // else Lambert: only diffuse_ and transmitted_ are set below
  bool anisotropic_ = false;
  Rgb glossy_albedo_{0.0f};
  Rgb cosine_albedo_{0.0f};
  Rgb transmitted_albedo_{0.0f};
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

  FilmLayer film_;
  float film_f0_[kFilmNodes]; // maximum channel, of the dielectric
  Rgb film_dielectric_f0_{0.0f}, film_metal_f0_{0.0f};
  float film_dielectric_ = 0.0f, film_metal_ = 0.0f; // weights
  float specular_ = 0.0f;
};

} // namespace kindling
