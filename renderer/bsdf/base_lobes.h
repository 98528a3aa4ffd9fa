// The opaque base of a layered surface: metal, and dielectric with diffuse reflection and diffuse transmission.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/bsdf/ggx_albedo.h"
#include "renderer/bsdf/ggx_lobe.h"
#include "renderer/bsdf/gltf_bsdf.h"
#include "renderer/bsdf/layer_parameters.h"

namespace kindling {

// The lobes of GltfBsdf (same formulas), with what the extensions do to them: anisotropy, iridescence, a share of the
// diffuse light that goes through, and a dielectric that is there only in part, since the rest of it transmits.
class BaseLobes {
 public:
  // Parameters in their ranges; wo unit with wo.z >= kMinCosTheta.
  BaseLobes(const BsdfParameters& parameters, const LayerParameters& layers, const V3f& wo);

  struct Eval {
    Rgb value{0.0f};        // f |cos_theta_i|
    float glossy_pdf{0.0f}; // of sample_glossy(), above the horizon
  };
  // wi unit, wi.z != 0, above or below the horizon.
  [[nodiscard]] Eval eval(const V3f& wi) const;
  [[nodiscard]] V3f sample_glossy(const V2f& u) const { return lobe_.sample(u); }

  // Directional albedos from wo: of single scattering (which sample_glossy() follows), of what follows the cosine above the surface and below it.
  [[nodiscard]] const Rgb& glossy_albedo() const { return glossy_albedo_; }
  [[nodiscard]] const Rgb& cosine_albedo() const { return cosine_albedo_; }
  [[nodiscard]] const Rgb& transmitted_albedo() const { return transmitted_albedo_; }

 private:
  GgxLobe lobe_;
  bool has_microfacets_ = false; // else Lambert: of what follows only diffuse_ and transmitted_ are set
  Rgb glossy_albedo_{0.0f};
  Rgb cosine_albedo_{0.0f};
  Rgb transmitted_albedo_{0.0f};
  Rgb diffuse_{0.0f};     // of the diffuse lobe all but (1 - S(i))
  Rgb transmitted_{0.0f}; // of diffuse transmission all but (1 - S(i))
  Rgb multiple_{0.0f};    // of the multiple-scattering lobe all but (1 - E(i))
  Rgb f0_{0.0f};
  float f90_ = 0.0f;
  // 1 - S = base_constant_ + base_e_ E + base_b_ B
  float base_constant_ = 1.0f;
  float base_e_ = 0.0f;
  float base_b_ = 0.0f;
  GgxAlbedoTable table_{1.0f, 1.0f};
};

} // namespace kindling
