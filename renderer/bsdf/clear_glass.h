// Clear glass: how its interface splits light, and the choice between its two directions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/base/math.h"
#include "renderer/bsdf/bsdf_ranges.h"
#include "renderer/bsdf/fresnel.h"
#include "renderer/bsdf/gltf_bsdf.h"
#include "renderer/bsdf/layer_parameters.h"

namespace kindling {

// Conventions are those of DielectricLobe. Real is a float for one microfacet, or Lanes for
// several; Each is a float, or Lanes if every microfacet has a material of its own.

inline constexpr float kMaxEta = 1e4f; // stands for an infinite index: F0 is 0.9996

// Returns a valid index of refraction; infinite ones are given as 0 (KHR_materials_ior).
template <typename Real>
[[nodiscard]] Real valid_eta(const Real& eta) {
  return select(eta > 0.0f, minimum(maximum(eta, Real(1.0f / kMaxEta)), Real(kMaxEta)), Real(kMaxEta));
}

// Returns a specular color without NaN and infinity.
template <typename Real>
[[nodiscard]] Imath::Vec3<Real> bounded_color(const Imath::Vec3<Real>& c) {
  const auto bounded = [](const Real& x) { return minimum(maximum(Real(0.0f), x), Real(1e6f)); };
  return {bounded(c.x), bounded(c.y), bounded(c.z)};
}

// The parts of light that a microfacet reflects and transmits; the latter includes the tint.
template <typename Real>
struct DielectricSplitOf {
  Imath::Vec3<Real> reflected, transmitted;
};

// Returns the parts without a film, before set_tint(). cos_o and cos_t are the cosines with the
// microfacet on the side of wo and beyond; cos_t < 0 is total reflection.
template <typename Real, typename Each>
[[nodiscard]] DielectricSplitOf<Real> split_by_fresnel(const SpecularFresnelOf<Each>& fresnel, const Real& cos_o,
                                                       const Real& cos_t, const Each& eta) {
  const Imath::Vec3<Real> f = fresnel(dielectric_fresnel(cos_o, cos_t, eta));
  const Real through = maximum(Real(1.0f - maximum(f.x, maximum(f.y, f.z))), Real(0.0f));
  return {f, {through, through, through}};
}

// Multiplies what is transmitted by the tint; total reflection leaves nothing of it.
template <typename Real, typename Each>
void set_tint(const Imath::Vec3<Each>& tint, const Real& cos_t, DielectricSplitOf<Real>& split) {
  const auto total = cos_t < 0.0f;
  for (int c = 0; c < 3; ++c) {
    split.reflected[c] = select(total, Real(1.0f), split.reflected[c]);
    split.transmitted[c] = select(total, Real(0.0f), Real(tint[c] * split.transmitted[c]));
  }
}

// Returns the probability to reflect, proportional to the luminances to either side. Below a
// millionth it is 0: such a sample is not worthwhile and its weight might not be finite.
template <typename Real>
[[nodiscard]] Real reflection_share(const DielectricSplitOf<Real>& split) {
  const Real reflected = luminance(split.reflected);
  const Real transmitted = luminance(split.transmitted);
  const Real sum = reflected + transmitted;
  const Real share = select(reflected > 1e-6f * sum, Real(reflected / sum), Real(0.0f));
  return select(transmitted <= 1e-6f * sum, Real(1.0f), share);
}

// A sampled delta direction of a smooth interface, reflected or refracted.
template <typename Real>
struct ClearSampleOf {
  MaskOf<Real> found, reflects; // unless it is found, all is absorbed, and the others are undefined
  Imath::Vec3<Real> wi, weight;
};

// `split` is that of wo's own cosine, and cos_t its refracted_cosine(); u_lobe in [0, 1) reflects
// below reflection_share(), as favored() by `odds`.
template <typename Real, typename Each>
[[nodiscard]] ClearSampleOf<Real> sample_clear(const DielectricSplitOf<Real>& split, const Imath::Vec3<Real>& wo,
                                               const Real& cos_t, const Each& eta, const Each& odds,
                                               const Real& u_lobe) {
  const Real probability = favored(reflection_share(split), Real(odds));
  const auto reflects = u_lobe < probability;
  const auto refracted = [&] {
    const Imath::Vec3<Real> wi(-wo.x / eta, -wo.y / eta, -cos_t);
    return Imath::Vec3<Real>(wi / square_root(Real(wi.length2())));
  };
  return {select(reflects, Real(1.0f), luminance(split.transmitted)) > 0.0f, reflects,
          select_result(
              reflects, [&] { return Imath::Vec3<Real>(-wo.x, -wo.y, wo.z); }, refracted),
          select_result(
              reflects, [&] { return Imath::Vec3<Real>(split.reflected * Real(1.0f / probability)); },
              [&] { return Imath::Vec3<Real>(split.transmitted * Real(1.0f / (1.0f - probability))); })};
}

// Returns whether LayeredBsdf is the boundary of a volume of glass and nothing else, whatever its
// roughness. A film may be on it.
[[nodiscard]] inline bool is_bare_glass(const BsdfParameters& p, const LayerParameters& layers) {
  return p.metallic <= 0.0f && layers.transmission >= 1.0f && !layers.thin_walled && layers.clearcoat <= 0.0f &&
         max_component(layers.sheen_color) <= 0.0f && layers.anisotropy <= 0.0f;
}

// Returns whether it is smooth as well: light is reflected and refracted into exact directions
// alone.
[[nodiscard]] inline bool is_clear_glass(const BsdfParameters& p, const LayerParameters& layers) {
  return p.roughness <= kStraightRoughness && is_bare_glass(p, layers);
}

// The LayeredBsdf of clear glass without a film, with the same bits: of one surface, or of several
// in lanes, each with its own parameters and direction.
template <typename Real>
class ClearGlassOf {
 public:
  // eta and odds: LayerParameters::eta and LayerParameters::reflection_odds.
  ClearGlassOf(const BsdfParametersOf<Real>& p, const Real& eta, const Real& odds, const Imath::Vec3<Real>& wo)
      : wo_(lifted_above_horizon(wo)), eta_(valid_eta(eta)), odds_(maximum(odds, Real(1.0f))),
        cos_t_(refracted_cosine(wo_.z, eta_)),
        split_(
            split_by_fresnel(SpecularFresnelOf<Real>(eta_, saturate(p.specular), bounded_color<Real>(p.specular_color)),
                             wo_.z, cos_t_, eta_)) {
    set_tint(saturate(p.base_color), cos_t_, split_);
  }

  // LayeredBsdf::sample(), which also finds nothing where the weight is black. The lobe is
  // Lobe::transmission unless it reflects.
  [[nodiscard]] ClearSampleOf<Real> sample(const Real& u_lobe) const {
    return sample_clear(split_, wo_, cos_t_, eta_, odds_, u_lobe);
  }

 private:
  Imath::Vec3<Real> wo_;
  Real eta_, odds_;
  Real cos_t_;
  DielectricSplitOf<Real> split_;
};

} // namespace kindling
