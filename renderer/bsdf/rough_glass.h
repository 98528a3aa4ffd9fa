// Rough glass: the boundary of a volume whose microfacets reflect and refract, and nothing else.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/base/math.h"
#include "renderer/bsdf/bsdf_eval.h"
#include "renderer/bsdf/bsdf_ranges.h"
#include "renderer/bsdf/clear_glass.h"
#include "renderer/bsdf/dielectric_albedo.h"
#include "renderer/bsdf/fresnel.h"
#include "renderer/bsdf/gltf_bsdf.h"
#include "renderer/bsdf/interface_facets.h"
#include "renderer/bsdf/layer_parameters.h"

namespace kindling {

// A volume's microfacets have at least this alpha; at or below it they are smooth.
inline constexpr float kSmoothAlpha = kStraightRoughness * kStraightRoughness;

// True if an interface of this index bends light too little to be anything but smooth.
template <typename Real>
[[nodiscard]] MaskOf<Real> is_matched(const Real& eta) {
  return minimum(eta, Real(1.0f / eta)) > kMatchedEta;
}

// Returns whether LayeredBsdf is the boundary of a volume of glass with rough microfacets, and
// nothing else, unless is_matched() by its valid_eta().
[[nodiscard]] inline bool is_rough_glass(const BsdfParameters& p, const LayerParameters& layers) {
  return p.roughness > kStraightRoughness && is_bare_glass(p, layers);
}

// Returns the part of light that is reflected, given those that the plain Fresnel term reflects and
// that are reflected totally.
template <typename Real>
[[nodiscard]] Imath::Vec3<Real> reflected_albedo(const SpecularFresnelOf<Real>& fresnel, const Real& plain,
                                                 const Real& total) {
  return saturate(Imath::Vec3<Real>((fresnel.offset() * Real(1.0f - total) + fresnel.slope() * Real(plain - total)) +
                                    Imath::Vec3<Real>(total)));
}

// The factor of single scattering at the boundary of a volume, and its estimated albedos, from the
// tables.
template <typename Real>
struct InterfaceAlbedosOf {
  Imath::Vec3<Real> scale, reflected;
};
// `fresnel` is that of the interface; a + b F is the Fresnel term with which reflected and
// transmitted light add up to 1.
template <typename Real>
[[nodiscard]] InterfaceAlbedosOf<Real>
interface_albedos(const DielectricAlbedoOf<Real>& albedo, const SpecularFresnelOf<Real>& fresnel,
                  const Imath::Vec3<Real>& a, const Imath::Vec3<Real>& b, const Real& eta) {
  const auto channel = [&](int c) {
    return Real(1.0f / maximum(Real(albedo.e + a[c] * albedo.p + (b[c] - 1.0f) * albedo.q), Real(0.02f)));
  };
  const Real plain = albedo.reflected; // fraction from the plain Fresnel term
  // Fraction from total reflection.
  const Real total = select(eta < 1.0f, maximum(Real(2.0f * plain - 1.0f), Real(0.0f)), Real(0.0f));
  return {{channel(0), channel(1), channel(2)}, reflected_albedo(fresnel, plain, total)};
}
// The LayeredBsdf of rough glass, with the same bits: of one surface, or of several in lanes, each
// with its own parameters and direction.
template <typename Real>
class RoughGlassOf {
 public:
  using Vector = Imath::Vec3<Real>;

  // eta: LayerParameters::eta, not is_matched().
  RoughGlassOf(const BsdfParametersOf<Real>& p, const Real& eta, const Vector& wo)
      : eta_(valid_eta(eta)), fresnel_(eta_, saturate(p.specular), bounded_color<Real>(p.specular_color)),
        tint_(saturate(p.base_color)) {
    const Real roughness = saturate(p.roughness);
    const Real alpha = maximum(Real(roughness * roughness), Real(kSmoothAlpha));
    facets_.wo = lifted_above_horizon(wo);
    facets_.alpha_x = facets_.alpha_y = alpha;
    facets_.set_stretched();
    // As much light as the channel that reflects most leaves is transmitted in all of them.
    const Real a = max_component(fresnel_.offset());
    const Real b = max_component(Vector(fresnel_.slope() + fresnel_.offset())) - a;
    const InterfaceAlbedosOf<Real> albedos =
        interface_albedos<Real>(dielectric_albedo(facets_.wo.z, minimum(square_root(alpha), Real(1.0f)), alpha, eta_),
                                fresnel_, Vector(a), Vector(b), eta_);
    scale_ = albedos.scale;
    const Vector transmitted = tint_ * Real(1.0f - max_component(albedos.reflected));
    scatters_ = luminance(Vector(albedos.reflected + transmitted)) > 0.0f;
  }

  // LayeredBsdf::eval() of unit directions, but its density.
  struct Eval {
    Vector value;
    Real pdf;
  };
  [[nodiscard]] Eval eval(const Vector& wi) const {
    const auto above = wi.z > 0.0f, below = wi.z < 0.0f;
    const Vector none(Real(0.0f));
    Eval result{none, 0.0f};
    if (any(above)) {
      const auto facet = facets_.mirroring(wi);
      const DielectricSplitOf<Real> here = split(facet.cos_d, refracted_cosine(facet.cos_d, eta_));
      const auto channel = [&](int c) { return Real(here.reflected[c] * (scale_[c] * facet.scale)); };
      result = {select(above, Vector(channel(0), channel(1), channel(2)), none),
                select(above, Real(reflection_share(here) * facet.density), Real(0.0f))};
    }
    if (any(below)) {
      const auto facet = facets_.refracting(wi, eta_);
      const auto found = select(below, select(facet.cos_o > 0.0f, facet.cos_t, Real(0.0f)), Real(0.0f)) > 0.0f;
      const DielectricSplitOf<Real> here = split(facet.cos_o, facet.cos_t);
      const Vector value = here.transmitted * (scale_ * facet.scale);
      const Real pdf = facets_.density(facet, Real(1.0f - reflection_share(here)));
      result = {select(found, value, result.value), select(found, pdf, result.pdf)};
    }
    result.pdf = select(scatters_, result.pdf, Real(0.0f));
    return result;
  }

  // LayeredBsdf::sample().
  struct Drawn {
    MaskOf<Real> found, reflects; // unless it is found, the others are undefined
    Vector wi, weight;
    Real pdf;
  };
  [[nodiscard]] Drawn sample(const Real& u_lobe, const Imath::Vec2<Real>& u) const {
    const Vector normal = facets_.sample_normal(u);
    const Real cos_o = facets_.wo.dot(normal);
    const Real cos_t = refracted_cosine(cos_o, eta_);
    const DielectricSplitOf<Real> here = split(cos_o, cos_t);
    const Real probability = reflection_share(here);
    const auto reflects = u_lobe < probability;
    const Vector wi = select_result(
        reflects, [&] { return Vector(normal * Real(2.0f * cos_o) - facets_.wo); },
        [&] { return refracted_direction(facets_.wo, normal, cos_t, eta_); });
    const Real chosen = select(reflects, probability, Real(1.0f - probability));
    const Real shadowing = facets_.shadowing(wi, absolute(wi.z));
    const Vector own = select(reflects, here.reflected, here.transmitted) * scale_ * Real(shadowing / chosen);
    const Real pdf = facets_.normal_density(normal, chosen) *
                     select(reflects, Real(0.5f), normals_per_refraction(cos_o, cos_t, eta_));
    const Real side = select(reflects, wi.z, Real(-wi.z));
    const auto found =
        select(scatters_, select(cos_o > 0.0f, select(side > 0.0f, pdf, Real(0.0f)), Real(0.0f)), Real(0.0f)) > 0.0f;
    const auto lit = select(reflects, Real(1.0f), luminance(here.transmitted)) > 0.0f;
    return {select(lit, select(found, Real(1.0f), Real(0.0f)), Real(0.0f)) > 0.0f, reflects, wi,
            own * pdf * Real(1.0f / pdf), pdf};
  }

  [[nodiscard]] Real alpha() const { return facets_.alpha_x; } // of the microfacets

 private:
  [[nodiscard]] DielectricSplitOf<Real> split(const Real& cos_o, const Real& cos_t) const {
    DielectricSplitOf<Real> result = split_by_fresnel(fresnel_, cos_o, cos_t, eta_);
    set_tint(tint_, cos_t, result);
    return result;
  }

  Real eta_;
  SpecularFresnelOf<Real> fresnel_;
  Vector tint_;
  InterfaceFacetsOf<Real> facets_;
  Vector scale_;
  MaskOf<Real> scatters_; // else all is absorbed
};

} // namespace kindling
