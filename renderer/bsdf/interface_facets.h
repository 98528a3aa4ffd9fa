// The geometry of a dielectric interface's microfacets, whatever Fresnel's term.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/base/math.h"
#include "renderer/bsdf/fresnel.h"
#include "renderer/bsdf/ggx_lobe.h"

namespace kindling {

// GGX with height-correlated Smith, as wo sees it; directions are unit and local, wo.z > 0. Each is
// a float for one interface, or Lanes if every lane has one of its own. Functions of Real are for
// floats, or for several directions in Lanes.
template <typename Each>
struct InterfaceFacetsOf {
  // Stretches wo, which must be set, as must be both alphas.
  void set_stretched() { t_o = stretched_length(wo); }

  // Returns the distribution of normals, given the squared coordinates of one.
  template <typename Real>
  [[nodiscard]] Real distribution(const Real& x2, const Real& y2, const Real& z2) const {
    const Real q = x2 / (alpha_x * alpha_x) + y2 / (alpha_y * alpha_y) + z2;
    return kInvPi / (alpha_x * alpha_y * q * q);
  }
  template <typename Real>
  [[nodiscard]] Real stretched_length(const Imath::Vec3<Real>& w) const {
    const Real x = alpha_x * w.x, y = alpha_y * w.y;
    return square_root(Real(x * x + y * y + w.z * w.z));
  }

  // A microfacet that mirrors wo into a direction.
  template <typename Real>
  struct Mirroring {
    Real cos_d;   // of the facet with both directions
    Real scale;   // of what it reflects, in f |cos_theta_i|
    Real density; // of the direction, if the facet does nothing else
  };
  // wi.z > 0.
  template <typename Real>
  [[nodiscard]] Mirroring<Real> mirroring(const Imath::Vec3<Real>& wi) const {
    const Real visibility = visible(wi, wi.z);
    const Real x = wo.x + wi.x, y = wo.y + wi.y, z = wo.z + wi.z; // the length is 2 cos(theta_d)
    const Real length2 = x * x + y * y + z * z;
    const Real cos_d = 0.5f * square_root(length2);
    const Real inverse = 1.0f / length2;
    const Real d = distribution(Real(x * x * inverse), Real(y * y * inverse), Real(z * z * inverse));
    return {cos_d, d * visibility * wi.z, 0.5f * d * visible_normals()};
  }

  // A microfacet that refracts wo into a direction; at least one of the cosines is not positive
  // where there is none.
  struct Refracting {
    Each cos_o, cos_t; // of the facet on the side of wo and beyond
    Each scale;        // of what it transmits, in f |cos_theta_i|
    Each d, jacobian;  // distribution of normals, and their solid angle over that of the direction
  };
  // wi.z < 0; eta as in fresnel.h. Walter et al. 2007, equations 16, 17 and 21, in terms of the
  // half vector before normalization, whose length is +-(cos_o - eta cos_t). The sign makes it
  // point to wo's side.
  [[nodiscard]] Refracting refracting(const Imath::Vec3<Each>& wi, const Each& eta) const {
    const Imath::Vec3<Each> sum = (wo + wi * eta) * select(eta > 1.0f, Each(-1.0f), Each(1.0f));
    const Each length2 = sum.length2();
    const Each inverse_length = 1.0f / square_root(length2);
    const Each cos_o = wo.dot(sum) * inverse_length;
    const Each cos_t = -wi.dot(sum) * inverse_length;
    const Each mu_i = -wi.z;
    const Each visibility = visible(wi, mu_i);
    const Each inverse = 1.0f / length2;
    const Each d =
        distribution(Each(sum.x * sum.x * inverse), Each(sum.y * sum.y * inverse), Each(sum.z * sum.z * inverse));
    const Each jacobian = eta * eta * cos_t * inverse;
    return {select(sum.z > 0.0f, cos_o, Each(0.0f)), cos_t, 4.0f * d * visibility * mu_i * cos_o * jacobian, d,
            jacobian};
  }
  // Returns the density of such a direction, given the probability that the facet refracts.
  [[nodiscard]] Each density(const Refracting& at, const Each& probability) const {
    return probability * 2.0f * at.d * visible_normals() * at.cos_o * at.jacobian;
  }

  // Samples a normal that wo sees, of unit length; u in [0, 1)^2.
  template <typename Real>
  [[nodiscard]] Imath::Vec3<Real> sample_normal(const Imath::Vec2<Real>& u) const {
    using Vector = Imath::Vec3<Real>;
    const Vector normal = sample_ggx_normal(wo, alpha_x, alpha_y, t_o, cap_bound, u);
    const Real length2 = normal.length2();
    return select(length2 > 0.0f, normal * Real(1.0f / square_root(length2)), Vector(0.0f, 0.0f, 1.0f));
  }
  // Returns G2 over G1 and over the bound of visible normals, for a sampled direction; mu_i =
  // |wi.z|.
  template <typename Real>
  [[nodiscard]] Real shadowing(const Imath::Vec3<Real>& wi, const Real& mu_i) const {
    return mu_i * bound() / (mu_i * t_o + wo.z * stretched_length(wi));
  }
  // Returns the density of a sampled normal over 2 (wo . h), times the probability of what it does.
  template <typename Real>
  [[nodiscard]] Real normal_density(const Imath::Vec3<Real>& normal, const Real& probability) const {
    return probability * distribution(Real(normal.x * normal.x), Real(normal.y * normal.y), Real(normal.z * normal.z)) /
           bound();
  }

  Imath::Vec3<Each> wo;
  Each alpha_x = 0.0f, alpha_y = 0.0f;
  Each t_o = 0.0f;       // length of the stretched wo
  Each cap_bound = 1.0f; // k of the bounded visible normals

 private:
  // Returns G2 / (4 mu_o mu_i), correlated in height (Heitz 2014, "Understanding the
  // Masking-Shadowing Function", equation 99); mu_i = |wi.z|.
  template <typename Real>
  [[nodiscard]] Real visible(const Imath::Vec3<Real>& wi, const Real& mu_i) const {
    return 0.5f / (mu_i * t_o + wo.z * stretched_length(wi));
  }
  [[nodiscard]] Each bound() const { return cap_bound * wo.z + t_o; }
  // Returns the density of visible normals over 2 D (wo . h).
  [[nodiscard]] Each visible_normals() const { return 1.0f / bound(); }
};

// Returns the density of a refracted direction over that of the normal that refracts into it, twice
// the latter over (wo . h). (cos_o - eta cos_t)^2 is computed without cancellation near eta = 1.
template <typename Real>
[[nodiscard]] Real normals_per_refraction(const Real& cos_o, const Real& cos_t, const Real& eta) {
  const Real difference = (1.0f - eta * eta) / (cos_o + eta * cos_t);
  return 2.0f * cos_o * eta * eta * cos_t / (difference * difference);
}

} // namespace kindling
